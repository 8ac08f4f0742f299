#include "raytrace/project/sharp_record.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace slim {
namespace {

/// Scales of a record's pixel grid at the depth where its rays are taken.
struct GridScale {
    double z_base, unit_per_px;
};

GridScale grid_of(const PixelView& view, double z_center, double radius) {
    if (view.orthographic) return {z_center, 1 / view.px_per_unit};
    // Near the eye the depth of the centre is no safe place for b0; the eye itself then is.
    const double z = z_center > 4 * radius ? z_center : 0;
    return {z, z / view.focal_px};
}

/// Pixel of the projected centre, bounded so that floats hold it exactly.
double nearest_pixel(double pixel_center, double c, double unit_per_px) {
    constexpr double kLimit = 1 << 23;
    if (!(unit_per_px > 0)) return 0;
    return std::clamp(std::floor(pixel_center + c / unit_per_px), -kLimit, kLimit);
}

std::array<float, 3> to_camera(const PixelView& view, const Vec3d& axis) {
    const Vec3f v = to_float(view.rotate_to_camera(axis));
    return {v.x, v.y, v.z};
}

/// Sheet `sheet` of a surfel in the form of the kernels.
DrawRecord sheet_record(const PixelView& view, const Surfel& s, std::size_t sheet,
                        std::uint32_t node) {
    const Vec3d c = view.camera_from_local(s.center);
    const GridScale grid = grid_of(view, c.z, s.support_radius);
    const double px = nearest_pixel(view.center_x, c.x, grid.unit_per_px);
    const double py = nearest_pixel(view.center_y, c.y, grid.unit_per_px);
    const double inv_radius = 1 / s.support_radius;
    DrawRecord r{};
    r.pixel_x = static_cast<float>(px);
    r.pixel_y = static_cast<float>(py);
    r.base_x =
        static_cast<float>(((px + 0.5 - view.center_x) * grid.unit_per_px - c.x) * inv_radius);
    r.base_y =
        static_cast<float>(((py + 0.5 - view.center_y) * grid.unit_per_px - c.y) * inv_radius);
    r.base_z = static_cast<float>((grid.z_base - c.z) * inv_radius);
    r.step = static_cast<float>(grid.unit_per_px * inv_radius);
    r.radius = static_cast<float>(s.support_radius);
    r.inv_radius = static_cast<float>(inv_radius);
    r.u_axis = to_camera(view, s.sheet_frame(sheet).u_axis);
    r.v_axis = to_camera(view, s.sheet_frame(sheet).v_axis);
    r.normal = to_camera(view, s.sheet_frame(sheet).normal);
    for (std::size_t k = 0; k < r.a.size(); ++k)
        r.a[k] = static_cast<float>(s.sheet_polynomial(sheet).a[k]);
    r.node = node;
    r.z_base = grid.z_base;
    r.z_center = c.z;
    return r;
}

}  // namespace

SharpRecord sharp_record(const PixelView& view, const Surfel& s, std::uint32_t node) {
    SharpRecord out;
    out.n_sheets = s.n_sheets();
    if (s.sharp) out.outer = s.sharp->outer, out.inner = s.sharp->inner;
    for (std::size_t i = 0; i < out.n_sheets; ++i) out.sheet[i] = sheet_record(view, s, i, node);
    return out;
}

}  // namespace slim
