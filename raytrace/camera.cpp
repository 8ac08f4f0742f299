#include "raytrace/camera.h"

#include "raytrace/framing.h"
#include "slim/base/angle.h"
#include "slim/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <sstream>
#include <vector>

namespace slim {
namespace {

struct NamedView {
    std::string_view name;
    Vec3d towards_eye;  ///< +Y up
    Vec3d up;
};

constexpr std::array<NamedView, 7> kNamedViews{{
    {"front", {0, 0, 1}, {0, 1, 0}},
    {"back", {0, 0, -1}, {0, 1, 0}},
    {"left", {-1, 0, 0}, {0, 1, 0}},
    {"right", {1, 0, 0}, {0, 1, 0}},
    {"top", {0, 1, 0}, {0, 0, -1}},
    {"bottom", {0, -1, 0}, {0, 0, 1}},
    {"iso", {1, 0.8, 1}, {0, 1, 0}},
}};

std::string text_of(const Vec3d& v) {
    std::ostringstream text;
    text << '(' << v.x << ", " << v.y << ", " << v.z << ')';
    return text.str();
}

[[noreturn]] void bad_camera(const std::string& what) {
    throw ConfigError({.key = "camera", .problem = what});
}

/// A direction of a view with y up in a world with another axis up: a rotation that keeps the front
/// view along -Z, or turns it along +Y where that axis is z.
Vec3d with_up(UpAxis up, const Vec3d& v) {
    switch (up) {
        case UpAxis::z:
            return {v.x, -v.z, v.y};
        case UpAxis::x:
            return {v.y, -v.x, v.z};
        case UpAxis::minus_y:
            return {-v.x, -v.y, v.z};
        case UpAxis::minus_z:
            return {-v.x, -v.z, -v.y};
        case UpAxis::minus_x:
            return {-v.y, v.x, v.z};
        default:
            return v;
    }
}

struct Basis {
    Vec3d right, down, forward;
};

Basis basis_of(const Camera& camera) {
    const Vec3d forward = normalized(camera.target - camera.eye);
    const Vec3d right = normalized(cross(forward, normalized(camera.up)));
    return {right, cross(forward, right), forward};
}

/// What is framed about the middle of its box: its points, or the box's corners.
std::vector<Vec3d> places_of(const Framed& framed) {
    std::vector<Vec3d> places;
    for (const Vec3d& p : framed.points) places.push_back(p - framed.box.center());
    if (!places.empty()) return places;
    const Vec3d h = framed.box.empty() ? Vec3d{} : framed.box.extent() * 0.5;
    for (unsigned i = 0; i < 8; ++i)
        places.push_back({i & 1u ? h.x : -h.x, i & 2u ? h.y : -h.y, i & 4u ? h.z : -h.z});
    return places;
}

// Positions of a turn that are looked at: between two, places move by less than the margin.
constexpr int kMostTurns = 72;

/// The same in camera axes, in each of its positions.
std::vector<Vec3d> turned_places(std::span<const Vec3d> places, const Basis& b, UpAxis up,
                                 int turns) {
    std::vector<Vec3d> out;
    const Vec3d x = with_up(up, {1, 0, 0}), y = with_up(up, {0, 1, 0}), z = with_up(up, {0, 0, 1});
    const int n = std::clamp(turns, 1, kMostTurns);
    for (int turn = 0; turn < n; ++turn) {
        const double angle = 2 * std::numbers::pi * turn / n;
        const double c = std::cos(angle), s = std::sin(angle);
        for (const Vec3d& p : places) {
            const double px = dot(p, x), pz = dot(p, z);
            const Vec3d q = x * (c * px - s * pz) + y * dot(p, y) + z * (s * px + c * pz);
            out.push_back({dot(b.right, q), dot(b.down, q), dot(b.forward, q)});
        }
    }
    return out;
}

}  // namespace

void validate(const Camera& c) {
    if (!is_finite(c.eye) || !is_finite(c.target) || !is_finite(c.up))
        bad_camera("eye, target and up must be finite, found " + text_of(c.eye) + " " +
                   text_of(c.target) + " " + text_of(c.up));
    const Vec3d view = c.target - c.eye;
    if (c.eye == c.target) bad_camera("eye and target are the same point " + text_of(c.eye));
    // Beyond, squares leave the range of doubles.
    constexpr double kNearest = 1e-150, kFarthest = 1e150;
    if (const double distance = length(view); !(distance >= kNearest && distance <= kFarthest))
        bad_camera("eye " + text_of(c.eye) + " must lie 1e-150 to 1e150 from the target " +
                   text_of(c.target));
    if (c.up == Vec3d{}) bad_camera("up is zero");
    if (const double size = length(c.up); !(size >= kNearest && size <= kFarthest))
        bad_camera("up must be 1e-150 to 1e150 long, found " + text_of(c.up));
    const Vec3d side = cross(normalized(view), normalized(c.up));
    if (!(length(side) > 1e-9)) bad_camera("up " + text_of(c.up) + " is parallel to the view");
    if (!c.orthographic && !(c.fov_y_deg > 0 && c.fov_y_deg < 180))
        bad_camera("fov_y_deg must lie in (0, 180), found " + std::to_string(c.fov_y_deg));
    // Of a narrower picture a pixel's number overflows doubles.
    constexpr double kNarrowest = 1e-100;
    if (c.orthographic && !(c.width >= kNarrowest && std::isfinite(c.width))) {
        std::ostringstream width;
        width << c.width;
        bad_camera("orthographic width must be at least 1e-100, found " + width.str());
    }
    if (!(c.near_plane >= 0 && std::isfinite(c.near_plane)))
        bad_camera("near plane must be >= 0, found " + std::to_string(c.near_plane));
}

Vec3d up_vector(UpAxis up) { return with_up(up, {0, 1, 0}); }

std::array<Vec3d, 3> upright_axes(UpAxis up) {
    return {with_up(up, {1, 0, 0}), with_up(up, {0, 1, 0}), with_up(up, {0, 0, 1})};
}

bool is_camera_name(std::string_view name) {
    return std::any_of(kNamedViews.begin(), kNamedViews.end(),
                       [&](const NamedView& v) { return v.name == name; });
}

const std::vector<std::string>& camera_names() {
    static const std::vector<std::string> kNames = [] {
        std::vector<std::string> names;
        for (const NamedView& view : kNamedViews) names.emplace_back(view.name);
        return names;
    }();
    return kNames;
}

FramedCamera framed_camera(std::string_view name, const Framed& framed, double aspect,
                           const Framing& framing) {
    const auto view = std::find_if(kNamedViews.begin(), kNamedViews.end(),
                                   [&](const NamedView& v) { return v.name == name; });
    if (view == kNamedViews.end())
        bad_camera("unknown view \"" + std::string(name) +
                   "\"; known: front, back, left, right, top, bottom, iso");
    const Vec3d towards = normalized(with_up(framing.up, view->towards_eye));
    Camera camera;
    camera.target = framed.box.empty() ? Vec3d{} : framed.box.center();
    camera.up = with_up(framing.up, view->up);
    camera.eye = camera.target + towards;
    camera.orthographic = framing.orthographic;
    camera.fov_y_deg = framing.fov_y_deg;
    const double tan_y = std::tan(radians(framing.fov_y_deg) / 2);
    const Basis basis = basis_of(camera);
    const auto places = turned_places(places_of(framed), basis, framing.up, framing.turns);
    const FreePart part(framing.margin, framing.free_right, framing.free_bottom);
    const FrameFit fit = framing.orthographic
                             ? fit_orthographic(places, aspect, part)
                             : fit_perspective(places, tan_y * aspect, tan_y, part);
    // What has no extent is framed as if it were of size 1.
    const double size = framed.box.diagonal() > 0 ? framed.box.diagonal() : 1.0;
    camera.width = fit.half_width > 0 ? 2 * fit.half_width : size;
    const double near_end = framing.orthographic ? fit.distance + size : fit.distance;
    const double distance = near_end > 0 ? near_end : size;
    camera.target = camera.target + basis.right * fit.step_right + basis.down * fit.step_down;
    camera.eye = camera.target + towards * distance;
    return {camera, basis.right * fit.middle_right + basis.down * fit.middle_down};
}

Camera named_camera(std::string_view name, const Framed& framed, double aspect,
                    const Framing& framing) {
    return framed_camera(name, framed, aspect, framing).camera;
}

PixelView pixel_view(const Camera& camera, int width, int height) {
    validate(camera);
    if (width < 1 || height < 1)
        throw ConfigError("picture size must be at least 1x1, found " + std::to_string(width) +
                          "x" + std::to_string(height));
    const Basis basis = basis_of(camera);
    PixelView view{camera.eye, basis.right, basis.down, basis.forward, camera.orthographic,
                   width / 2.0, height / 2.0, 0, 0, camera.near_plane};
    view.focal_px = height / 2.0 / std::tan(radians(camera.fov_y_deg) / 2);
    view.px_per_unit = width / camera.width;
    if (view.near_plane == 0) view.near_plane = 1e-6 * length(camera.target - camera.eye);
    return view;
}

Vec3d PixelView::ray_origin(double px, double py) const {
    if (!orthographic) return eye;
    return eye + right * ((px - center_x) / px_per_unit) + down * ((py - center_y) / px_per_unit);
}

Vec3d PixelView::ray_direction(double px, double py) const {
    if (orthographic) return forward;
    return normalized(right * ((px - center_x) / focal_px) + down * ((py - center_y) / focal_px) +
                      forward);
}

Vec3d PixelView::point_at(double px, double py, double z) const {
    const double scale = orthographic ? 1 / px_per_unit : z / focal_px;
    return eye + right * ((px - center_x) * scale) + down * ((py - center_y) * scale) + forward * z;
}

}  // namespace slim
