#include "raytrace/legend_room.h"

#include <algorithm>
#include <array>
#include <vector>

namespace slim {
namespace {

/// A place in the picture, 0 to 1 both ways from the top left.
struct Place {
    double x, y;
};

double side(const Place& a, const Place& b, const Place& p) {
    return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

/// Places as a camera sees them. What a named camera frames lies before it.
std::vector<Place> seen(const Camera& camera, const Framed& framed, double aspect) {
    constexpr int kHeight = 1000;
    const int width = std::max(1, static_cast<int>(aspect * kHeight));
    const PixelView view = pixel_view(camera, width, kHeight);
    std::vector<Vec3d> places(framed.points.begin(), framed.points.end());
    const Vec3d lo = framed.box.lo, hi = framed.box.hi;
    for (unsigned i = 0; i < 8 && framed.points.empty(); ++i)
        places.push_back({i & 1u ? hi.x : lo.x, i & 2u ? hi.y : lo.y, i & 4u ? hi.z : lo.z});
    std::vector<Place> out;
    for (const Vec3d& p : places) {
        const Vec3d c = view.camera_from_local(p);
        const double scale = view.orthographic ? view.px_per_unit : view.focal_px / c.z;
        out.push_back({(view.center_x + c.x * scale) / width,
                       (view.center_y + c.y * scale) / kHeight});
    }
    return out;
}

/// Convex hull, counter-clockwise as `side` counts (Andrew 1979).
std::vector<Place> hull_of(std::vector<Place> places) {
    std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
        return a.x < b.x || (a.x == b.x && a.y < b.y);
    });
    std::vector<Place> hull;
    for (int half = 0; half < 2; ++half) {
        const std::size_t start = hull.size();
        for (const Place& p : places) {
            while (hull.size() >= start + 2 &&
                   side(hull[hull.size() - 2], hull.back(), p) <= 0)
                hull.pop_back();
            hull.push_back(p);
        }
        hull.pop_back();
        std::reverse(places.begin(), places.end());
    }
    return hull;
}

/// Whether a line parallel to the box or to the hull parts them.
bool apart(const std::vector<Place>& hull, const Place& lo, const Place& hi) {
    const auto all = [&](const auto& outside) {
        return std::all_of(hull.begin(), hull.end(), outside);
    };
    if (all([&](const Place& p) { return p.x <= lo.x; }) ||
        all([&](const Place& p) { return p.x >= hi.x; }) ||
        all([&](const Place& p) { return p.y <= lo.y; }) ||
        all([&](const Place& p) { return p.y >= hi.y; }))
        return true;
    const std::array<Place, 4> corners{lo, {hi.x, lo.y}, hi, {lo.x, hi.y}};
    for (std::size_t i = 0; i < hull.size(); ++i) {
        const Place &a = hull[i], &b = hull[(i + 1) % hull.size()];
        if (std::all_of(corners.begin(), corners.end(),
                        [&](const Place& p) { return side(a, b, p) < 0; }))
            return true;
    }
    return false;
}

bool has_free_corner(const Camera& camera, const Framed& framed, double aspect,
                     const LegendRoom& room, bool lower_left) {
    const std::vector<Place> hull = hull_of(seen(camera, framed, aspect));
    const double w = room.corner_width, h = room.corner_height;
    const bool beside_bar = room.bar_width + w <= 1;
    return (beside_bar && apart(hull, {1 - w, 1 - h}, {1, 1})) || apart(hull, {1 - w, 0}, {1, h}) ||
           apart(hull, {0, 0}, {w, h}) || (lower_left && apart(hull, {0, 1 - h}, {w, 1}));
}

/// What is larger is nearer to the camera, or seen by a narrower one.
double smallness(const Camera& camera) {
    return camera.orthographic ? camera.width : length(camera.eye - camera.target);
}

}  // namespace

bool leaves_room(const Camera& camera, const Framed& framed, double aspect,
                 const LegendRoom& room) {
    constexpr double kUsual = 0.7;  // of the largest legend, which the room is for
    LegendRoom usual = room;
    for (double* side : {&usual.right, &usual.bottom, &usual.corner_width, &usual.corner_height})
        *side *= kUsual;
    const std::vector<Place> hull = hull_of(seen(camera, framed, aspect));
    const auto is_free = [&](double right, double bottom) {
        return apart(hull, {1 - right, 1 - bottom}, {1, 1});
    };
    return (usual.right > 0 && is_free(usual.right, 1)) ||
           (usual.bottom > 0 && is_free(1, usual.bottom)) ||
           (usual.corner_width > 0 && has_free_corner(camera, framed, aspect, usual, true));
}

bool leaves_bar_room(const Camera& camera, const Framed& framed, double aspect,
                     const LegendRoom& room) {
    return apart(hull_of(seen(camera, framed, aspect)), {0, 1 - room.bar_height},
                 {room.bar_width, 1});
}

FramedCamera framed_beside(std::string_view name, const Framed& framed, double aspect,
                           const Framing& framing, const LegendRoom& room) {
    const auto with = [&](double free_right, double free_bottom) {
        Framing own = framing;
        own.free_right = free_right, own.free_bottom = free_bottom;
        return framed_camera(name, framed, aspect, own);
    };
    const auto beside_bar = [&](double free_right) {
        if (framing.free_bottom > 0 && framing.turns <= 1 && room.bar_width > 0 &&
            !framed.box.empty()) {
            const FramedCamera bare = with(free_right, 0);
            if (leaves_bar_room(bare.camera, framed, aspect, room)) return bare;
        }
        return with(free_right, framing.free_bottom);
    };
    const FramedCamera beside = beside_bar(room.right);
    if (room.right <= 0 || framing.turns > 1) return beside;
    if (room.corner_width > 0 && !framed.box.empty()) {
        const FramedCamera bare = beside_bar(0);
        if (has_free_corner(bare.camera, framed, aspect, room, framing.free_bottom <= 0))
            return bare;
    }
    if (room.bottom <= 0) return beside;
    constexpr double kLarger = 1.03;
    const FramedCamera above = with(0, std::max(framing.free_bottom, room.bottom));
    return smallness(above.camera) * kLarger <= smallness(beside.camera) ? above : beside;
}

}  // namespace slim
