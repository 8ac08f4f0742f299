#include "raytrace/camera.h"

#include "slim/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <sstream>

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

/// The same view in a world whose up is +Z.
Vec3d to_z_up(const Vec3d& v) { return {v.x, -v.z, v.y}; }

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

struct Basis {
    Vec3d right, down, forward;
};

Basis basis_of(const Camera& camera) {
    const Vec3d forward = normalized(camera.target - camera.eye);
    const Vec3d right = normalized(cross(forward, normalized(camera.up)));
    return {right, cross(forward, right), forward};
}

/// Half extents of the box about its centre as the camera sees them: the largest of each bound.
struct Fit {
    double distance = 0;    ///< eye to centre so that all corners are inside the frustum
    double half_width = 0;  ///< orthographic
    double depth = 0;       ///< largest |z| of a corner
};

Fit fit_box(const Bbox& box, const Basis& b, double tan_x, double tan_y, double aspect) {
    Fit fit;
    const Vec3d h = box.extent() * 0.5;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3d p{corner & 1 ? h.x : -h.x, corner & 2 ? h.y : -h.y, corner & 4 ? h.z : -h.z};
        const double x = std::abs(dot(b.right, p)), y = std::abs(dot(b.down, p));
        const double z = dot(b.forward, p);
        fit.distance = std::max({fit.distance, x / tan_x - z, y / tan_y - z});
        fit.half_width = std::max({fit.half_width, x, y * aspect});
        fit.depth = std::max(fit.depth, std::abs(z));
    }
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
    const Vec3d towards = normalized(framing.z_up ? to_z_up(view->towards_eye) : view->towards_eye);
    Camera camera;
    camera.target = box.empty() ? Vec3d{} : box.center();
    camera.up = framing.z_up ? to_z_up(view->up) : view->up;
    camera.eye = camera.target + towards;
    camera.orthographic = framing.orthographic;
    camera.fov_y_deg = framing.fov_y_deg;
    const double tan_y = std::tan(radians(framing.fov_y_deg) / 2) * (1 - framing.margin);
    const Fit fit = fit_box(box, basis_of(camera), tan_y * aspect, tan_y, aspect);
    // A box without extent is framed as if it were of size 1.
    const double size = box.diagonal() > 0 ? box.diagonal() : 1.0;
    camera.width = fit.half_width > 0 ? 2 * fit.half_width / (1 - framing.margin) : size;
    const double distance = framing.orthographic ? fit.depth + size : fit.distance;
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
