#include "raytrace/project/draw_list.h"

#include "slim/base/parallel.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace slim {
namespace {

/// Pixel indices [lo, hi) whose centres lie in the interval of pixel coordinates, with a guard of a
/// thousandth of a pixel, clipped to [begin, end).
void pixel_range(double lo, double hi, int begin, int end, int& first, int& last) {
    constexpr double kGuard = 1e-3;
    lo = std::clamp(std::ceil(lo - 0.5 - kGuard), double(begin), double(end));
    hi = std::clamp(std::floor(hi - 0.5 + kGuard) + 1, double(begin), double(end));
    first = static_cast<int>(lo);
    last = static_cast<int>(hi);
}

/// Bounds of x / z over a ball with z > radius (NUMERICS 7.2).
void slope_bounds(double x, double z, double radius, double& lo, double& hi) {
    const double l = std::sqrt(x * x + (z - radius) * (z + radius));
    lo = (x * l - radius * z) / (z * l + radius * x);
    hi = (x * l + radius * z) / (z * l - radius * x);
}

/// Stable order of the keys: least significant digit first, 11 bits at a time.
std::vector<std::uint32_t> sorted_order(const std::vector<std::uint32_t>& keys) {
    constexpr std::uint32_t kDigits = 2048;
    std::vector<std::uint32_t> order(keys.size()), other(keys.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    for (int shift = 0; shift < 33; shift += 11) {
        std::vector<std::uint32_t> start(kDigits + 1, 0);
        for (const std::uint32_t key : keys) ++start[((key >> shift) & (kDigits - 1)) + 1];
        for (std::uint32_t d = 0; d < kDigits; ++d) start[d + 1] += start[d];
        for (const std::uint32_t i : order) other[start[(keys[i] >> shift) & (kDigits - 1)]++] = i;
        order.swap(other);
    }
    return order;
}

/// Bits of a float as an integer of the same order.
std::uint32_t ordered_bits(float x) {
    const auto bits = std::bit_cast<std::uint32_t>(x);
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

/// Scales of a record's pixel grid at the depth where its rays are taken.
struct PixelGrid {
    double z_base, unit_per_px;
};

PixelGrid grid_of(const PixelView& view, double z_center, double radius) {
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
    const PixelGrid grid = grid_of(view, c.z, s.support_radius);
    const double px = nearest_pixel(view.center_x, c.x, grid.unit_per_px);
    const double py = nearest_pixel(view.center_y, c.y, grid.unit_per_px);
    const double inv_radius = 1 / s.support_radius;
    DrawRecord r{};
    r.pixel_x = static_cast<float>(px);
    r.pixel_y = static_cast<float>(py);
    r.base_x = static_cast<float>(((px + 0.5 - view.center_x) * grid.unit_per_px - c.x) * inv_radius);
    r.base_y = static_cast<float>(((py + 0.5 - view.center_y) * grid.unit_per_px - c.y) * inv_radius);
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

/// Further sheets of what is drawn; nothing at all for smooth models.
void add_sharp(const PixelView& view, const SurfelTree& tree, DrawList& list) {
    if (tree.sharp().empty()) return;
    list.sharp_of.assign(list.records.size(), kSmooth);
    for (std::size_t i = 0; i < list.records.size(); ++i) {
        const std::uint32_t node = list.records[i].node;
        if (!(tree.node(node).flags & kSharp)) continue;
        list.sharp_of[i] = static_cast<std::uint32_t>(list.sharp.size());
        list.sharp.push_back(sharp_record(view, tree, node));
    }
}

}  // namespace

ScreenRect screen_rect(const PixelView& view, const PixelWindow& w, const Vec3d& c, double radius) {
    ScreenRect rect{w.x, w.y, w.x + w.width, w.y + w.height};
    if (c.z + radius < view.near_plane) return {};
    double lo_x, hi_x, lo_y, hi_y, scale;
    if (view.orthographic) {
        lo_x = c.x - radius, hi_x = c.x + radius, lo_y = c.y - radius, hi_y = c.y + radius;
        scale = view.px_per_unit;
    } else {
        if (c.z <= radius) return rect;
        slope_bounds(c.x, c.z, radius, lo_x, hi_x);
        slope_bounds(c.y, c.z, radius, lo_y, hi_y);
        scale = view.focal_px;
    }
    pixel_range(view.center_x + lo_x * scale, view.center_x + hi_x * scale, rect.x0, rect.x1,
                rect.x0, rect.x1);
    pixel_range(view.center_y + lo_y * scale, view.center_y + hi_y * scale, rect.y0, rect.y1,
                rect.y0, rect.y1);
    return rect;
}

DrawRecord draw_record(const PixelView& view, const SurfelTree& tree, std::uint32_t node) {
    return sheet_record(view, tree.surfel(node), 0, node);
}

SharpRecord sharp_record(const PixelView& view, const SurfelTree& tree, std::uint32_t node) {
    const Surfel s = tree.surfel(node);
    SharpRecord out;
    out.n_sheets = s.n_sheets();
    out.outer = s.sharp->outer;
    out.inner = s.sharp->inner;
    for (std::size_t i = 0; i < out.n_sheets; ++i) out.sheet[i] = sheet_record(view, s, i, node);
    return out;
}

DrawList draw_list(const PixelView& view, const PixelWindow& window, const SurfelTree& tree,
                   std::span<const std::uint32_t> cut) {
    std::vector<ScreenRect> rects(cut.size());
    std::vector<std::uint32_t> keys(cut.size());
    const double z_root = tree.n_nodes() > 0 ? view.camera_from_local(tree.center(0)).z : 0;
    constexpr std::size_t kGrain = 1024;
    parallel_blocks(cut.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3d c = view.camera_from_local(tree.center(cut[i]));
            const double radius = tree.support_radius(cut[i]);
            rects[i] = screen_rect(view, window, c, radius);
            keys[i] = ordered_bits(static_cast<float>(c.z - kHitTrim * radius - z_root));
        }
    });
    std::vector<std::uint32_t> order = sorted_order(keys);
    std::erase_if(order, [&](std::uint32_t i) { return rects[i].empty(); });
    DrawList list;
    list.records.resize(order.size());
    list.full.resize(order.size());
    list.trimmed.resize(order.size());
    list.rims.resize(order.size());
    parallel_blocks(order.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint32_t node = cut[order[i]];
            list.records[i] = draw_record(view, tree, node);
            list.full[i] = rects[order[i]];
            list.rims[i] = tree.node(node).rims();
            list.trimmed[i] = screen_rect(view, window, view.camera_from_local(tree.center(node)),
                                          kHitTrim * tree.support_radius(node));
        }
    });
    add_sharp(view, tree, list);
    return list;
}

}  // namespace slim
