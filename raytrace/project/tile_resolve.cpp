#include "raytrace/project/tile_resolve.h"

#include "raytrace/intersect/curvature_kernel.h"
#include "raytrace/intersect/third_order_kernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>

namespace slim {
namespace {

/// Where a tile lands in the G-buffer.
struct Target {
    const PixelWindow& window;
    const TileBuffers& t;
    bool whole;  ///< all of the tile lies in the window

    Target(const PixelWindow& of, const TileBuffers& tile)
        : window(of), t(tile),
          whole(t.clip.x1 - t.clip.x0 == kTileSize && t.clip.y1 - t.clip.y0 == kTileSize) {}

    std::size_t in_buffer(int x, int y) const {
        return static_cast<std::size_t>(y - window.y) * static_cast<std::size_t>(window.width) +
               static_cast<std::size_t>(x - window.x);
    }

    /// Writes the pixels of a block that lie in the window.
    template <class T>
    void put_block(int row, int column, const T* lanes, T* to) const {
        const int x = t.x0 + column * kBlockWidth, y = t.y0 + row * kBlockHeight;
        if (whole) {
            T* out = to + in_buffer(x, y);
            for (int k = 0; k < kBlockHeight; ++k, out += window.width)
                std::copy_n(lanes + k * kBlockWidth, kBlockWidth, out);
            return;
        }
        const int x_0 = std::max(x, t.clip.x0), x_1 = std::min(x + kBlockWidth, t.clip.x1);
        const int y_0 = std::max(y, t.clip.y0), y_1 = std::min(y + kBlockHeight, t.clip.y1);
        if (x_1 - x_0 == kBlockWidth) {
            for (int py = y_0; py < y_1; ++py)
                std::copy_n(lanes + (py - y) * kBlockWidth, kBlockWidth, to + in_buffer(x, py));
            return;
        }
        for (int py = y_0; py < y_1; ++py)
            for (int px = x_0; px < x_1; ++px)
                to[in_buffer(px, py)] = lanes[(py - y) * kBlockWidth + px - x];
    }

    /// visit(block row, block column, entry in the tile) for all blocks.
    template <class Visit>
    static void for_each_block(Visit&& visit) {
        for (int row = 0; row < kBlockRows; ++row)
            for (int column = 0; column < kBlockColumns; ++column)
                visit(row, column, block_start(row, column));
    }

    void copy(const TilePlane& from, std::vector<float>& to) const {
        for_each_block([&](int row, int column, std::size_t i) {
            put_block(row, column, from.v + i, to.data());
        });
    }

    /// visit(entry in the tile, entry in the G-buffer) for each pixel of the window.
    template <class Visit>
    void for_each_pixel(Visit&& visit) const {
        for (int y = t.clip.y0; y < t.clip.y1; ++y)
            for (int x = t.clip.x0; x < t.clip.x1; ++x)
                visit(pixel_entry(x - t.x0, y - t.y0), in_buffer(x, y));
    }
};

/// Pixels of the G-buffer of a tile, or of some side by side.
struct TileInWindow {
    int x0, y0, x1, y1;
    TileInWindow(const PixelWindow& window, int first_x, int first_y, int width)
        : x0(std::max(first_x, window.x) - window.x), y0(std::max(first_y, window.y) - window.y),
          x1(std::min(first_x + width - window.x, window.width)),
          y1(std::min(first_y + kTileSize - window.y, window.height)) {}
};

bool is_hit(float z) { return std::abs(z) < std::numeric_limits<float>::infinity(); }

/// Averages: z becomes the blended depth, z - z_ref, if one is wanted, sum_* the blended gradient
/// (that of q^ without weight). Infinite depths go on meaning no hit. Returns through the counts.
void average(const TileSums& sums, TileBuffers& t) {
    for (std::size_t i = 0; i < kTilePixels; i += kLanes) {
        const FloatV z = t.z.load(i);
        const auto hit = has_hit(z);
        const FloatV w = t.weight.load(i);
        const auto blended = hit && w > 0.0f;
        t.counts.covered += static_cast<std::uint64_t>(stdx::popcount(hit));
        t.counts.unblended += static_cast<std::uint64_t>(stdx::popcount(hit && !blended));
        if (sums.depth) {
            const FloatV depth = t.depths.relative<FloatV>(z) +
                                 select<FloatV>(blended, t.offset.load(i) / w, FloatV(0.0f));
            t.z.store(i, select<FloatV>(hit, depth, z));
        }
        if (stdx::all_of(blended)) continue;
        t.sum_x.store(i, select<FloatV>(blended, t.sum_x.load(i), t.gx.load(i)));
        t.sum_y.store(i, select<FloatV>(blended, t.sum_y.load(i), t.gy.load(i)));
        t.sum_z.store(i, select<FloatV>(blended, t.sum_z.load(i), t.gz.load(i)));
    }
}

void write_hits(const Target& target, const TileBuffers& t, GBuffer& out) {
    target.for_each_block([&](int row, int column, std::size_t i) {
        std::array<std::uint8_t, kLanes> hit;
        const auto bits = lane_bits(has_hit(t.z.load(i)));
        for (std::size_t k = 0; k < kLanes; k += 4) {  // bit j of four to byte j
            const auto bytes =
                static_cast<std::uint32_t>((bits >> k & 15) * 0x00204081u & 0x01010101u);
            std::memcpy(hit.data() + k, &bytes, 4);
        }
        target.put_block(row, column, hit.data(), out.hit.data());
    });
}

void write_depth(const Target& target, const TileBuffers& t, GBuffer& out) {
    target.for_each_pixel([&](std::size_t i, std::size_t pixel) {
        const bool hit = is_hit(t.z.v[i]);
        out.depth[pixel] =
            hit ? static_cast<float>(t.depths.z_ref + static_cast<double>(t.z.v[i])) : 0.0f;
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

/// Blended gradients, unit.
void write_normals(const PixelView& view, const Target& target, const TileBuffers& t,
                   GBuffer& out) {
    const Rotation rotation(view);
    target.for_each_block([&](int row, int column, std::size_t i) {
        const FloatV x = t.sum_x.load(i), y = t.sum_y.load(i), z = t.sum_z.load(i);
        const FloatV scale =
            select<FloatV>(has_hit(t.z.load(i)), inverse_sqrt(x * x + y * y + z * z), FloatV(0.0f));
        for (std::size_t axis = 0; axis < 3; ++axis) {
            alignas(64) std::array<float, kLanes> n;
            const FloatV turned = rotation.component(axis, scale * x, scale * y, scale * z);
            select<FloatV>(has_hit(t.z.load(i)), turned, FloatV(0.0f))
                .copy_to(n.data(), stdx::vector_aligned);
            target.put_block(row, column, n.data(), out.normal[axis].data());
        }
    });
}

/// P = point of the ray at z_ref + direction (z - z_ref): the first part is affine in the pixel,
/// and all terms are of the size of the model, however far the camera.
void write_positions(const PixelView& view, const Target& target, TileBuffers& t, GBuffer& out) {
    const Rotation rotation(view);
    const Vec3d corner = view.point_at(t.x0 + 0.5, t.y0 + 0.5, t.depths.z_ref);
    const Vec3f start = to_float(corner);
    const Vec3f step_x = to_float(view.point_at(t.x0 + 1.5, t.y0 + 0.5, t.depths.z_ref) - corner);
    const Vec3f step_y = to_float(view.point_at(t.x0 + 0.5, t.y0 + 1.5, t.depths.z_ref) - corner);
    const std::array<TilePlane*, 3> position{&t.gx, &t.gy, &t.gz};
    target.for_each_block([&](int row, int column, std::size_t i) {
        const FloatV x = lane_columns() + static_cast<float>(column * kBlockWidth);
        const FloatV y = lane_rows() + static_cast<float>(row * kBlockHeight);
        const auto hit = has_hit(t.z.load(i));
        const FloatV along = t.z.load(i) * t.inv_dz.load(i);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const FloatV turned =
                rotation.component(axis, t.dx.load(i), t.dy.load(i), t.dz.load(i));
            const FloatV p = start[axis] + step_x[axis] * x + step_y[axis] * y + turned * along;
            position[axis]->store(i, select<FloatV>(hit, p, FloatV(0.0f)));
        }
    });
    for (std::size_t axis = 0; axis < 3; ++axis) target.copy(*position[axis], out.position[axis]);
}

/// Principal directions and derivatives along them, before the Hessian's planes are used up; pixels
/// that kept q^ have none. The planes of the gradient of q^ are free after the average.
void write_directions(const PixelView& view, const Target& target, bool cubic, TileBuffers& t,
                      GBuffer& out) {
    const Rotation rotation(view);
    const std::array<TilePlane*, 3> direction{&t.gx, &t.gy, &t.gz};
    const FloatV zero(0.0f);
    for (std::size_t i = 0; i < kTilePixels; i += kLanes) {
        std::array<FloatV, 6> h;
        for (std::size_t k = 0; k < 6; ++k) h[k] = t.hessian[k].load(i);
        const auto p =
            principal_lanes<FloatV>(t.sum_x.load(i), t.sum_y.load(i), t.sum_z.load(i), h);
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
        const auto k =
            curvature_lanes<FloatV>(t.sum_x.load(i), t.sum_y.load(i), t.sum_z.load(i), h);
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
        const std::uint32_t node =
            hit ? items[entries[static_cast<std::size_t>(t.winner.v[i])]].node : 0;
        if (out.has(kSurfelIdChannel)) out.surfel_id[pixel] = node;
        if (out.has(kFitErrorChannel))
            out.fit_error[pixel] = hit ? tree.node(node).fit_error : 0.0f;
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
    const Target target(window, t);
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

void fetch_tile(const PixelWindow& window, int first_x, int first_y, GBuffer& out) {
    constexpr std::ptrdiff_t kLine = 64;
    const TileInWindow on(window, first_x, first_y, kTileSize);
    const auto fetch = [&](auto& plane) {
        if (plane.empty() || on.x0 >= on.x1) return;
        for (int y = on.y0; y < on.y1; ++y) {
            const auto* first = reinterpret_cast<const char*>(plane.data() + out.index(on.x0, y));
            const auto* last =
                reinterpret_cast<const char*>(plane.data() + out.index(on.x1 - 1, y));
            for (; first < last; first += kLine) __builtin_prefetch(first, 1, 2);
            __builtin_prefetch(last, 1, 2);
        }
    };
    fetch(out.hit);
    out.for_each_plane(fetch);
}

void clear_tiles(const PixelWindow& window, int first_x, int first_y, int n_tiles, GBuffer& out) {
    const TileInWindow on(window, first_x, first_y, n_tiles * kTileSize);
    if (on.x0 >= on.x1) return;
    const auto clear = [&](auto& plane) {
        if (plane.empty()) return;
        for (int y = on.y0; y < on.y1; ++y)
            std::fill_n(plane.begin() + static_cast<std::ptrdiff_t>(out.index(on.x0, y)),
                        on.x1 - on.x0, 0);
    };
    clear(out.hit);
    out.for_each_plane(clear);
}

}  // namespace slim
