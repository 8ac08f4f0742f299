#include "raytrace/project/tile_resolve.h"

#include "raytrace/intersect/curvature_kernel.h"
#include "raytrace/intersect/third_order_kernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace slim {
namespace {

/// Where a tile lands in the G-buffer.
struct Target {
    const PixelWindow& window;
    const TileBuffers& t;

    int width() const { return t.clip.x1 - t.clip.x0; }
    /// Entry of pixel (x, y) of the picture in a tile plane, and in the G-buffer.
    std::size_t in_tile(int x, int y) const {
        return static_cast<std::size_t>((y - t.y0) * kTileSize + (x - t.x0));
    }
    std::size_t in_buffer(int x, int y) const {
        return static_cast<std::size_t>(y - window.y) * static_cast<std::size_t>(window.width) +
               static_cast<std::size_t>(x - window.x);
    }

    void copy(const TilePlane& from, std::vector<float>& to) const {
        for (int y = t.clip.y0; y < t.clip.y1; ++y)
            std::copy_n(from.v + in_tile(t.clip.x0, y), width(),
                        to.data() + in_buffer(t.clip.x0, y));
    }

    /// Calls lanes_at(entry in the tile) -> FloatV for each group of lanes and writes its pixels in the window.
    template <class LanesAt>
    void put(std::vector<float>& to, LanesAt&& lanes_at) const {
        for (int y = t.clip.y0; y < t.clip.y1; ++y)
            for (int x = t.x0; x < t.clip.x1; x += kLanes) {
                const FloatV lanes = lanes_at(in_tile(x, y));
                if (x >= t.clip.x0 && x + kLanes <= t.clip.x1) {
                    lanes.copy_to(to.data() + in_buffer(x, y), stdx::element_aligned);
                    continue;
                }
                for (int k = std::max(0, t.clip.x0 - x); k < std::min(kLanes, t.clip.x1 - x); ++k)
                    to[in_buffer(x + k, y)] = lanes[static_cast<std::size_t>(k)];
            }
    }

    /// visit(entry in the tile, entry in the G-buffer) for each pixel of the window.
    template <class Visit>
    void for_each_pixel(Visit&& visit) const {
        for (int y = t.clip.y0; y < t.clip.y1; ++y)
            for (int x = t.clip.x0; x < t.clip.x1; ++x) visit(in_tile(x, y), in_buffer(x, y));
    }
};

bool is_hit(float z) { return std::abs(z) < std::numeric_limits<float>::infinity(); }

/// Averages: z becomes the blended depth if wanted, sum_* the blended gradient (that of q^ without weight). Infinite
/// depths go on meaning no hit. Returns through the counts.
void average(const TileSums& sums, TileBuffers& t) {
    for (std::size_t i = 0; i < kTilePixels; i += kLanes) {
        const FloatV z = t.z.load(i);
        const auto hit = has_hit(z);
        const FloatV w = t.weight.load(i);
        const auto blended = hit && w > 0.0f;
        t.counts.covered += static_cast<std::uint64_t>(stdx::popcount(hit));
        t.counts.unblended += static_cast<std::uint64_t>(stdx::popcount(hit && !blended));
        if (sums.depth) t.z.store(i, z + select<FloatV>(blended, t.offset.load(i) / w, FloatV(0.0f)));
        if (stdx::all_of(blended)) continue;
        t.sum_x.store(i, select<FloatV>(blended, t.sum_x.load(i), t.gx.load(i)));
        t.sum_y.store(i, select<FloatV>(blended, t.sum_y.load(i), t.gy.load(i)));
        t.sum_z.store(i, select<FloatV>(blended, t.sum_z.load(i), t.gz.load(i)));
    }
}

void write_hits(const Target& target, const TileBuffers& t, GBuffer& out) {
    target.for_each_pixel([&](std::size_t i, std::size_t pixel) { out.hit[pixel] = is_hit(t.z.v[i]); });
}

void write_depth(const Target& target, const TileBuffers& t, GBuffer& out) {
    target.for_each_pixel([&](std::size_t i, std::size_t pixel) {
        const bool hit = is_hit(t.z.v[i]);
        out.depth[pixel] = hit ? static_cast<float>(t.z_ref + static_cast<double>(t.z.v[i])) : 0.0f;
    });
}

/// Camera axes to the frame of the job, in lanes; component `axis` of the result.
struct Rotation {
    std::array<Vec3f, 3> columns;
    explicit Rotation(const PixelView& v)
        : columns{to_float(v.right), to_float(v.down), to_float(v.forward)} {}
    FloatV component(std::size_t axis, const FloatV& x, const FloatV& y, const FloatV& z) const {
        return columns[0][axis] * x + columns[1][axis] * y + columns[2][axis] * z;
    }
};

/// Blended gradients, unit; the planes of q^'s own are free after the average and take them in between.
void write_normals(const PixelView& view, const Target& target, TileBuffers& t, GBuffer& out) {
    const Rotation rotation(view);
    for (std::size_t i = 0; i < kTilePixels; i += kLanes) {
        const FloatV x = t.sum_x.load(i), y = t.sum_y.load(i), z = t.sum_z.load(i);
        const FloatV scale = inverse_sqrt(x * x + y * y + z * z);
        t.gx.store(i, scale * x), t.gy.store(i, scale * y), t.gz.store(i, scale * z);
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
        target.put(out.normal[axis], [&](std::size_t i) {
            const FloatV n = rotation.component(axis, t.gx.load(i), t.gy.load(i), t.gz.load(i));
            return select<FloatV>(has_hit(t.z.load(i)), n, FloatV(0.0f));
        });
}

/// P = point of the ray at z_ref + direction (z - z_ref): the first part is affine in the pixel, and all
/// terms are of the size of the model, however far the camera.
void write_positions(const PixelView& view, const Target& target, TileBuffers& t, GBuffer& out) {
    const Rotation rotation(view);
    const Vec3d corner = view.point_at(t.x0 + 0.5, t.y0 + 0.5, t.z_ref);
    const Vec3f start = to_float(corner);
    const Vec3f step_x = to_float(view.point_at(t.x0 + 1.5, t.y0 + 0.5, t.z_ref) - corner);
    const Vec3f step_y = to_float(view.point_at(t.x0 + 0.5, t.y0 + 1.5, t.z_ref) - corner);
    const std::array<TilePlane*, 3> position{&t.gx, &t.gy, &t.gz};
    const FloatV lane([](auto k) { return static_cast<float>(k); });
    for (std::size_t i = 0; i < kTilePixels; i += kLanes) {
        const FloatV x = lane + static_cast<float>(i % kTileSize);
        const FloatV y(static_cast<float>(i / kTileSize));
        const auto hit = has_hit(t.z.load(i));
        const FloatV along = t.z.load(i) * t.inv_dz.load(i);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const FloatV turned =
                rotation.component(axis, t.dx.load(i), t.dy.load(i), t.dz.load(i));
            const FloatV p = start[axis] + step_x[axis] * x + step_y[axis] * y + turned * along;
            position[axis]->store(i, select<FloatV>(hit, p, FloatV(0.0f)));
        }
    }
    for (std::size_t axis = 0; axis < 3; ++axis) target.copy(*position[axis], out.position[axis]);
}

/// Principal directions and derivatives along them, before the Hessian's planes are used up; pixels
/// that kept q^ have none. The planes of the winner's gradient are free, as in write_normals.
void write_directions(const PixelView& view, const Target& target, bool cubic, TileBuffers& t,
                      GBuffer& out) {
    const Rotation rotation(view);
    const std::array<TilePlane*, 3> direction{&t.gx, &t.gy, &t.gz};
    const FloatV zero(0.0f);
    for (std::size_t i = 0; i < kTilePixels; i += kLanes) {
        std::array<FloatV, 6> h;
        for (std::size_t k = 0; k < 6; ++k) h[k] = t.hessian[k].load(i);
        const auto p = principal_lanes<FloatV>(t.sum_x.load(i), t.sum_y.load(i), t.sum_z.load(i), h);
        const auto known = t.weight.load(i) > 0.0f;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const FloatV along = rotation.component(axis, p.t1[0], p.t1[1], p.t1[2]);
            direction[axis]->store(i, select<FloatV>(known, along, zero));
        }
        if (!cubic || !out.has(kThirdOrderChannel)) continue;
        std::array<FloatV, 10> c;
        for (std::size_t k = 0; k < 10; ++k) c[k] = t.third[k].load(i);
        const auto q = third_order_lanes<FloatV>(p, h, c);
        for (std::size_t k = 0; k < 4; ++k) t.third[k].store(i, select<FloatV>(known, q[k], zero));
    }
    if (out.has(kDirectionChannel))
        for (std::size_t axis = 0; axis < 3; ++axis)
            target.copy(*direction[axis], out.direction[axis]);
    if (out.has(kThirdOrderChannel))
        for (std::size_t k = 0; k < 4; ++k) target.copy(t.third[k], out.third[k]);
}

/// Pixels that kept q^ have no Hessian: their curvature is 0.
void write_curvature(const Target& target, TileBuffers& t, GBuffer& out) {
    for (std::size_t i = 0; i < kTilePixels; i += kLanes) {
        std::array<FloatV, 6> h;
        for (std::size_t k = 0; k < 6; ++k) h[k] = t.hessian[k].load(i);
        const auto k = curvature_lanes<FloatV>(t.sum_x.load(i), t.sum_y.load(i), t.sum_z.load(i), h);
        const auto known = t.weight.load(i) > 0.0f;
        const FloatV zero(0.0f);
        t.hessian[0].store(i, select<FloatV>(known, k.k1, zero));
        t.hessian[1].store(i, select<FloatV>(known, k.k2, zero));
        t.hessian[2].store(i, select<FloatV>(known, k.mean, zero));
        t.hessian[3].store(i, select<FloatV>(known, k.gauss, zero));
    }
    if (out.has(kK1Channel)) target.copy(t.hessian[0], out.k1);
    if (out.has(kK2Channel)) target.copy(t.hessian[1], out.k2);
    if (out.has(kMeanChannel)) target.copy(t.hessian[2], out.mean);
    if (out.has(kGaussChannel)) target.copy(t.hessian[3], out.gauss);
}

/// What the node of the surfel that set q^ says of itself.
void write_fit(const Target& target, const SurfelTree& tree, std::span<const DrawItem> items,
               std::span<const std::uint32_t> entries, const TileBuffers& t, GBuffer& out) {
    target.for_each_pixel([&](std::size_t i, std::size_t pixel) {
        const bool hit = is_hit(t.z.v[i]);
        const std::uint32_t node = hit ? items[entries[static_cast<std::size_t>(t.winner.v[i])]].node : 0;
        if (out.has(kSurfelIdChannel)) out.surfel_id[pixel] = node;
        if (out.has(kFitErrorChannel)) out.fit_error[pixel] = hit ? tree.node(node).fit_error : 0.0f;
        if (out.has(kLevelChannel)) out.level[pixel] = hit ? tree.node(node).level : 0.0f;
    });
}

void write_count(const Target& target, const TileBuffers& t, GBuffer& out) {
    target.for_each_pixel([&](std::size_t i, std::size_t pixel) {
        out.count[pixel] = is_hit(t.z.v[i]) ? static_cast<std::uint32_t>(t.count.v[i]) : 0;
    });
}

}  // namespace

void resolve_tile(const PixelView& view, const PixelWindow& window, const SurfelTree& tree,
                  std::span<const DrawItem> items, std::span<const std::uint32_t> entries,
                  const TileSums& sums, TileBuffers& t, GBuffer& out) {
    const Target target{window, t};
    average(sums, t);
    write_hits(target, t, out);
    if (out.has(kDepthChannel)) write_depth(target, t, out);
    if (out.has(kNormalChannel)) write_normals(view, target, t, out);
    if (out.has_any(kDirectionChannel | kThirdOrderChannel))
        write_directions(view, target, tree.header().degree >= 3, t, out);
    if (out.has_any(kCurvatureChannel)) write_curvature(target, t, out);
    if (out.has(kPositionChannel)) write_positions(view, target, t, out);
    if (out.has(kCoverageChannel)) target.copy(t.weight, out.coverage);
    if (sums.node) write_fit(target, tree, items, entries, t, out);
    if (sums.count) write_count(target, t, out);
}

void clear_tile(const PixelWindow& window, int first_x, int first_y, GBuffer& out) {
    const int x0 = std::max(first_x, window.x) - window.x, y0 = std::max(first_y, window.y) - window.y;
    const int x1 = std::min(first_x + kTileSize - window.x, window.width);
    const int y1 = std::min(first_y + kTileSize - window.y, window.height);
    if (x0 >= x1) return;
    const auto clear = [&](auto& plane) {
        if (plane.empty()) return;
        for (int y = y0; y < y1; ++y)
            std::fill_n(plane.begin() + static_cast<std::ptrdiff_t>(out.index(x0, y)), x1 - x0, 0);
    };
    clear(out.hit);
    out.for_each_plane(clear);
}

}  // namespace slim
