#include "raytrace/camera.h"

#include "slim/base/angle.h"
#include "slim/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
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

[[noreturn]] void bad_camera(const std::string& what) { throw ConfigError("camera: " + what); }

/// A direction of a view with y up in a world with another axis up: a rotation that keeps the front view
/// along -Z, or turns it along +Y where that axis is z.
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

/// The part of the picture that a box may fill: how far from the axis to each side, 1 being half the
/// picture's width or height.
struct FreePart {
    double left, right, vertical;
    bool centred;  ///< the box stays in the middle of the picture
    explicit FreePart(const Framing& f)
        : left(1 - f.margin), right(1 - f.margin - 2 * f.free_right), vertical(1 - f.margin),
          centred(f.free_right <= 0) {}
};

struct Fit {
    double distance = 0;    ///< eye to centre so that all corners are inside the frustum
    double half_width = 0;  ///< orthographic: half the picture
    double step_right = 0;  ///< of the camera, model units
};

/// The corners of a box about its centre, in camera axes, in each of its positions.
std::vector<Vec3d> corners_of(const Bbox& box, const Basis& b, UpAxis up, int turns) {
    std::vector<Vec3d> corners;
    const Vec3d h = box.extent() * 0.5;
    const Vec3d x = with_up(up, {1, 0, 0}), y = with_up(up, {0, 1, 0}), z = with_up(up, {0, 0, 1});
    for (int turn = 0; turn < std::max(1, turns); ++turn) {
        const double angle = 2 * std::numbers::pi * turn / std::max(1, turns);
        const double c = std::cos(angle), s = std::sin(angle);
        for (unsigned i = 0; i < 8; ++i) {
            const Vec3d p{i & 1u ? h.x : -h.x, i & 2u ? h.y : -h.y, i & 4u ? h.z : -h.z};
            const double px = dot(p, x), pz = dot(p, z);
            const Vec3d q = x * (c * px - s * pz) + y * dot(p, y) + z * (s * px + c * pz);
            corners.push_back({dot(b.right, q), dot(b.down, q), dot(b.forward, q)});
        }
    }
    return corners;
}

/// A corner at x stays inside if -left <= (x - step) / (tan_x (distance + z)) <= right. The left bound
/// at step 0 and the sum of both give the distance, then the right one gives the step.
Fit fit_perspective(std::span<const Vec3d> corners, double tan_x, double tan_y,
                    const FreePart& part) {
    const double infinity = std::numeric_limits<double>::infinity();
    double past_right = -infinity, past_left = -infinity;
    Fit fit;
    for (const Vec3d& c : corners) {
        past_right = std::max(past_right, c.x - part.right * tan_x * c.z);
        past_left = std::max(past_left, -c.x - part.left * tan_x * c.z);
        fit.distance = std::max(fit.distance, std::abs(c.y) / (tan_y * part.vertical) - c.z);
    }
    const double either_side = (past_right + past_left) / (part.left + part.right);
    fit.distance = std::max({fit.distance, past_left / (tan_x * part.left), either_side / tan_x});
    if (part.centred) fit.distance = std::max(fit.distance, past_right / (tan_x * part.right));
    else fit.step_right = std::max(0.0, past_right - part.right * tan_x * fit.distance);
    return fit;
}

Fit fit_orthographic(std::span<const Vec3d> corners, double aspect, const FreePart& part) {
    double x = 0, y = 0, z = 0;
    for (const Vec3d& c : corners)
        x = std::max(x, c.x), y = std::max(y, c.y), z = std::max(z, c.z);
    Fit fit;
    fit.half_width = std::max(2 * x / (part.left + part.right), y * aspect / part.vertical);
    if (!part.centred) fit.step_right = std::max(0.0, x - part.right * fit.half_width);
    fit.distance = z;
    return fit;
}

}  // namespace

void validate(const Camera& c) {
    if (!is_finite(c.eye) || !is_finite(c.target) || !is_finite(c.up))
        bad_camera("eye, target and up must be finite, found " + text_of(c.eye) + " " +
                   text_of(c.target) + " " + text_of(c.up));
    const Vec3d view = c.target - c.eye;
    if (!(length(view) > 0)) bad_camera("eye and target are the same point " + text_of(c.eye));
    const Vec3d side = cross(normalized(view), normalized(c.up));
    if (!(length(side) > 1e-9))
        bad_camera("up " + text_of(c.up) + " is zero or parallel to the view");
    if (!c.orthographic && !(c.fov_y_deg > 0 && c.fov_y_deg < 180))
        bad_camera("fov_y_deg must lie in (0, 180), found " + std::to_string(c.fov_y_deg));
    if (c.orthographic && !(c.width > 0 && std::isfinite(c.width)))
        bad_camera("orthographic width must be > 0, found " + std::to_string(c.width));
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

Camera named_camera(std::string_view name, const Bbox& box, double aspect,
                    const Framing& framing) {
    const auto view = std::find_if(kNamedViews.begin(), kNamedViews.end(),
                                   [&](const NamedView& v) { return v.name == name; });
    if (view == kNamedViews.end())
        bad_camera("unknown view \"" + std::string(name) +
                   "\"; known: front, back, left, right, top, bottom, iso");
    const Vec3d towards = normalized(with_up(framing.up, view->towards_eye));
    Camera camera;
    camera.target = box.empty() ? Vec3d{} : box.center();
    camera.up = with_up(framing.up, view->up);
    camera.eye = camera.target + towards;
    camera.orthographic = framing.orthographic;
    camera.fov_y_deg = framing.fov_y_deg;
    const double tan_y = std::tan(radians(framing.fov_y_deg) / 2);
    const Basis basis = basis_of(camera);
    const auto corners = corners_of(box, basis, framing.up, framing.turns);
    const FreePart part(framing);
    const Fit fit = framing.orthographic
                        ? fit_orthographic(corners, aspect, part)
                        : fit_perspective(corners, tan_y * aspect, tan_y, part);
    // A box without extent is framed as if it were of size 1.
    const double size = box.diagonal() > 0 ? box.diagonal() : 1.0;
    camera.width = fit.half_width > 0 ? 2 * fit.half_width : size;
    const double distance = framing.orthographic ? fit.distance + size : fit.distance;
    camera.target = camera.target + basis.right * fit.step_right;
    camera.eye = camera.target + towards * (distance > 0 ? distance : size);
    return camera;
}

PixelView pixel_view(const Camera& camera, int width, int height) {
    validate(camera);
    if (width < 1 || height < 1)
        throw ConfigError("picture size must be at least 1x1, found " + std::to_string(width) + "x" +
                          std::to_string(height));
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
