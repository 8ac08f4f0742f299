#include "raytrace/project/tile_resolve.h"

#include "raytrace/intersect/curvature_kernel.h"
#include "raytrace/intersect/third_order_kernel.h"

#include <algorithm>
#include <array>

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

    /// visit(entry in the tile, entry in the G-buffer) for each pixel with a hit.
    template <class Visit>
    void for_each_hit(Visit&& visit) const {
        for (int y = t.clip.y0; y < t.clip.y1; ++y)
            for (int x = t.clip.x0; x < t.clip.x1; ++x)
                if (t.winner.v[in_tile(x, y)] >= 0) visit(in_tile(x, y), in_buffer(x, y));
    }
};

/// Averages: z becomes the blended depth, sum_* the blended gradient (the winner's without weight);
/// lanes without a hit become 0. Returns through the counts.
void average(TileBuffers& t) {
    const FloatV zero(0.0f);
    for (std::size_t i = 0; i < kTilePixels; i += kLanes) {
        const auto hit = t.winner.load(i) >= 0.0f;
        const FloatV w = t.weight.load(i);
        const auto blended = hit && w > 0.0f;
        t.counts.covered += static_cast<std::uint64_t>(stdx::popcount(hit));
        t.counts.unblended += static_cast<std::uint64_t>(stdx::popcount(hit && !blended));
        const FloatV z = t.z.load(i) + select<FloatV>(blended, t.offset.load(i) / w, zero);
        t.z.store(i, select<FloatV>(hit, z, zero));
        t.sum_x.store(i, select<FloatV>(blended, t.sum_x.load(i), t.gx.load(i)));
        t.sum_y.store(i, select<FloatV>(blended, t.sum_y.load(i), t.gy.load(i)));
        t.sum_z.store(i, select<FloatV>(blended, t.sum_z.load(i), t.gz.load(i)));
    }
}

void write_depth(const Target& target, TileBuffers& t, GBuffer& out) {
    target.for_each_hit([&](std::size_t i, std::size_t pixel) {
        out.hit[pixel] = 1;
        if (out.has(kDepthChannel))
            out.depth[pixel] = static_cast<float>(t.z_ref + static_cast<double>(t.z.v[i]));
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

/// The planes of the winner's gradient are free after the average: gx, gy, gz hold what is written.
void write_normals(const PixelView& view, const Target& target, TileBuffers& t, GBuffer& out) {
    const Rotation rotation(view);
    const std::array<TilePlane*, 3> normal{&t.gx, &t.gy, &t.gz};
    for (std::size_t i = 0; i < kTilePixels; i += kLanes) {
        const auto hit = t.winner.load(i) >= 0.0f;
        const FloatV x = t.sum_x.load(i), y = t.sum_y.load(i), z = t.sum_z.load(i);
        const FloatV scale =
            select<FloatV>(hit, 1.0f / stdx::sqrt(x * x + y * y + z * z), FloatV(0.0f));
        for (std::size_t axis = 0; axis < 3; ++axis)
            normal[axis]->store(i, scale * rotation.component(axis, x, y, z));
    }
    for (std::size_t axis = 0; axis < 3; ++axis) target.copy(*normal[axis], out.normal[axis]);
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
        const auto hit = t.winner.load(i) >= 0.0f;
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
void write_directions(const PixelView& view, const Target& target, bool have_third, TileBuffers& t,
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
        if (!have_third) continue;
        std::array<FloatV, 10> c;
        for (std::size_t k = 0; k < 10; ++k) c[k] = t.third[k].load(i);
        const auto q = third_order_lanes<FloatV>(p, h, c);
        for (std::size_t k = 0; k < 4; ++k) t.third[k].store(i, select<FloatV>(known, q[k], zero));
    }
    if (out.has(kDirectionChannel))
        for (std::size_t axis = 0; axis < 3; ++axis)
            target.copy(*direction[axis], out.direction[axis]);
    if (have_third)
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

/// What the winner's node says of itself.
void write_fit(const Target& target, const SurfelTree& tree, const DrawList& list,
               std::span<const std::uint32_t> entries, const TileBuffers& t, GBuffer& out) {
    target.for_each_hit([&](std::size_t i, std::size_t pixel) {
        const std::uint32_t node =
            list.records[entries[static_cast<std::size_t>(t.winner.v[i])]].node;
        if (out.has(kSurfelIdChannel)) out.surfel_id[pixel] = node;
        if (out.has(kFitErrorChannel)) out.fit_error[pixel] = tree.node(node).fit_error;
        if (out.has(kLevelChannel)) out.level[pixel] = tree.node(node).level;
        if (out.has(kCountChannel)) out.count[pixel] = static_cast<std::uint32_t>(t.count.v[i]);
    });
}

}  // namespace

void resolve_tile(const PixelView& view, const PixelWindow& window, const SurfelTree& tree,
                  const DrawList& list, std::span<const std::uint32_t> entries, TileBuffers& t,
                  GBuffer& out) {
    const Target target{window, t};
    average(t);
    if (t.counts.covered == 0) return;
    write_depth(target, t, out);
    if (out.has(kNormalChannel)) write_normals(view, target, t, out);
    if (out.has_any(kDirectionChannel | kThirdOrderChannel))
        write_directions(view, target, out.has(kThirdOrderChannel) && tree.header().degree >= 3, t,
                         out);
    if (out.has_any(kCurvatureChannel)) write_curvature(target, t, out);
    if (out.has(kPositionChannel)) write_positions(view, target, t, out);
    if (out.has(kCoverageChannel)) target.copy(t.weight, out.coverage);
    constexpr Channels kOfNode = kSurfelIdChannel | kFitErrorChannel | kLevelChannel | kCountChannel;
    if (out.channels & kOfNode) write_fit(target, tree, list, entries, t, out);
}

}  // namespace slim
