#pragma once

#include "raytrace/intersect/pixel_kernel.h"
#include "raytrace/project/block_spans.h"
#include "raytrace/project/draw_list.h"
#include "raytrace/project/general_stages.h"
#include "raytrace/project/tile_buffers.h"
#include "raytrace/project/tile_lanes.h"
#include "slim/model/surfel.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <new>
#include <span>

namespace slim {

// What works on a surfel's lanes is one function, flattened, and all it calls is always inline: g++ 12 leaves out some calls as
// kernels grow, and passes the lanes through memory.

/// A surfel's depths in the tile's coordinate: zeta = zeta_c + tau / per_zeta.
struct DepthScale {
    float zeta_c, per_zeta, per_tau;

    DepthScale(const DrawItem& item, double radius, const TileDepths& d) {
        const double ratio = 1 + (item.z_center - d.z_ref) * d.per_ref;  // z_c / z_ref
        zeta_c = static_cast<float>((item.z_center - d.z_ref) / ratio);
        per_tau = static_cast<float>(radius / (ratio * ratio));
        per_zeta = static_cast<float>(ratio * ratio / radius);
    }
    [[gnu::always_inline]] FloatV tau_of(const FloatV& zeta) const { return (zeta - zeta_c) * per_zeta; }
    [[gnu::always_inline]] FloatV zeta_of(const FloatV& tau) const { return zeta_c + per_tau * tau; }
};

/// One surfel on one tile.
template <int Degree>
struct SurfelOnTile {
    using Row = RowOf<Degree, FloatV>;
    const PixelRecord<Degree>& record;
    RimLanes rim;
    DepthScale depth;
    TileBuffers& t;

    SurfelOnTile(const PixelRecord<Degree>& r, const DrawItem& item, TileBuffers& tile)
        : record(r), rim(item.rims), depth(item, static_cast<double>(r.radius), tile.depths), t(tile) {}

    /// Calls visit(row, s, entry) for the blocks that an outline touches; sq_radius is that of the ball in `row`.
    template <class Visit>
    [[gnu::always_inline]] void for_each_block(const ScreenRect& rect, const Outline& outline, float sq_radius,
                                               Visit&& visit) const {
        const ScreenRect on = t.on_tile(rect);
        if (on.empty()) return;
        const TileGrid grid(record, t);
        const BlockSpans spans(outline, grid, on);
        std::uint8_t blocks[kTileBlocks + kBlockColumns];
        const int n = spans.list(blocks);
        // Unions keep what they hold from being set beforehand.
        union Rows {
            Row row[kBlockRows];
            Rows() {}
        } rows;
        // Counted from the record's own pixel, whole numbers: s and t to the last bit wherever the tile begins.
        const FloatV left = lane_columns() + (static_cast<float>(t.x0) - record.pixel_x);
        const FloatV top = lane_rows() + (static_cast<float>(t.y0) - record.pixel_y);
        for (int y = spans.row_0; y < spans.row_1; ++y)
            new (rows.row + y) Row(record, (top + static_cast<float>(y * kBlockHeight)) * record.step + record.base_y,
                                   sq_radius);
        for (int k = 0; k < n; ++k) {
            const int block = blocks[k];
            const FloatV x = left + static_cast<float>(block % kBlockColumns * kBlockWidth);
            visit(rows.row[block / kBlockColumns], x * record.step + record.base_x,
                  static_cast<std::size_t>(block * kLanes));
        }
    }
};

/// Bounds of the roots that count.
struct TauRange {
    float least, most;
};

/// Stage 1 of some pixels: first root inside the shrunken ball, kept if nearer.
template <int Degree>
[[gnu::always_inline]] inline void first_hits(const SurfelOnTile<Degree>& surfel, const RowOf<Degree, FloatV>& row,
                                              const FloatV& s, std::size_t i, const TauRange& range, float entry,
                                              const TileSums& sums) {
    TileBuffers& t = surfel.t;
    const auto root = first_in_ball<Degree, FloatV>(row.polynomial(s), row.ball(s), range.most, range.least);
    const FloatV zeta = surfel.depth.zeta_of(root.t);
    // No way out where none is: the next step's cost is less than that of a wrong guess.
    auto nearer = root.hit && zeta < t.z.load(i);
    const FloatV share = row.share(root.t);
    if (!surfel.rim.is_whole) {
        const auto [u, v] = row.plane(s, root.t, share);
        nearer = nearer && surfel.rim.share(u, v) > 0.0f;
    }
    keep_nearer(t, i, entry, nearer, zeta, row.gradient(s, root.t, share), sums);
}

/// Stage 1 of one surfel; blocks all of which is nearer than it are passed over.
template <int Degree>
[[gnu::flatten, gnu::noinline]] void draw_first(const PixelRecord<Degree>& r, const DrawItem& item,
                                                const ScreenRect& rect, const Outline& outline, float entry,
                                                const TileSums& sums, TileBuffers& t) {
    constexpr float kSqTrim = static_cast<float>(kHitTrim * kHitTrim);
    const SurfelOnTile<Degree> surfel(r, item, t);
    const float nearest = t.depths.at(item.near_hit - 1e-5 * static_cast<double>(r.radius));
    // tau is below 1 / (1 / R - kappa) in the ball.
    const TauRange range{(t.depths.at(0) - surfel.depth.zeta_c) * surfel.depth.per_zeta,
                         1 / (static_cast<float>(1 / kHitTrim) - r.kappa)};
    surfel.for_each_block(rect, outline, kSqTrim,
                          [&](const auto& row, const FloatV& s, std::size_t i) __attribute__((always_inline)) {
        if (stdx::none_of(t.z.load(i) > nearest)) return;
        t.counts.root_tests += kLanes;
        first_hits<Degree>(surfel, row, s, i, range, entry, sums);
    });
}

/// Stage 2 of some pixels: eqs (6) and (7) around q^, with the gates of add_supporter (slim/blend).
template <int Degree, bool kWantHessian, bool kSharpModel, bool kWantThird>
[[gnu::always_inline]] inline void blend(const SurfelOnTile<Degree>& surfel, const RowOf<Degree, FloatV>& row,
                                         const FloatV& s, std::size_t i, float reach, const TileSums& sums) {
    constexpr float kFarthest = static_cast<float>(kBelongs), kSqFarthest = kFarthest * kFarthest;
    const PixelRecord<Degree>& r = surfel.record;
    TileBuffers& t = surfel.t;
    const FloatV guess = surfel.depth.tau_of(t.z.load(i));
    const BallLanes<FloatV> ball = row.ball(s), around = about(ball, guess);
    t.counts.distance_tests += kLanes;
    const auto inside = around.n < 0.0f;
    if (stdx::none_of(inside)) return;
    t.counts.root_tests += kLanes;
    const auto root = nearest_in_ball<Degree, FloatV>(about(row.polynomial(s), guess), around, reach, inside);
    const FloatV tau = guess + root.t, share = row.share(tau);
    // |q - q^|^2 (h h^)^2, from the ball's function where h = 0: the ray's point at infinity.
    const FloatV heights = row.height(tau) * row.height(guess);
    const FloatV sq_gap = root.t * root.t * (ball.l + r.kappa * (ball.m + r.kappa * ball.n));
    const auto g = row.gradient(s, tau, share);
    auto taken = root.hit && sq_gap <= kSqFarthest * (heights * heights) && admitted<kSharpModel>(g, i, t);
    FloatV rim_share(1.0f);
    if (!surfel.rim.is_whole) {
        const auto [u, v] = row.plane(s, tau, share);
        rim_share = surfel.rim.share(u, v);
        taken = taken && rim_share > 0.0f;
    }
    const FloatV sq_distance = 1.0f + around.value(root.t) * (share * share);
    const FloatV dz = r.radius * root.t / heights;
    add_to_sums(t, i, taken, rim_share, sq_distance, dz, g, sums,
                [&](const FloatV& w) __attribute__((always_inline)) {
                    if constexpr (!kWantHessian) return;
                    const auto at = row.plane(s, tau, share);
                    for (std::size_t n = 0; n < 6; ++n) t.hessian[n].add(i, w * row.hessian(n, at));
                    if constexpr (!kWantThird) return;
                    const auto c = third_of(r);
                    for (std::size_t n = 0; n < 10; ++n) t.third[n].add(i, w * c[n]);
                });
}

/// Stage 2 of one surfel.
template <int Degree, bool kWantHessian, bool kSharpModel, bool kWantThird>
[[gnu::flatten, gnu::noinline]] void draw_blend(const PixelRecord<Degree>& r, const DrawItem& item,
                                                const ScreenRect& rect, const Outline& outline, const TileSums& sums,
                                                TileBuffers& t) {
    const SurfelOnTile<Degree> surfel(r, item, t);
    // |dq/dtau| is at least 1 / h^2, and h at most 1 / (1 - kappa).
    const float reach = 1.001f * static_cast<float>(kBelongs) / ((1 - r.kappa) * (1 - r.kappa));
    surfel.for_each_block(rect, outline, 1,
                          [&](const auto& row, const FloatV& s, std::size_t i) __attribute__((always_inline)) {
        blend<Degree, kWantHessian, kSharpModel, kWantThird>(surfel, row, s, i, reach, sums);
    });
}

/// Asks for what draw_first or draw_blend will read of a later surfel.
template <int Degree>
void fetch_surfel(const DrawList<Degree>& list, const Outline* outlines, const ScreenRect* rects,
                  std::span<const std::uint32_t> entries, std::size_t e) {
    constexpr std::size_t kAhead = 2, kLine = 64;
    if (e + kAhead >= entries.size()) return;
    const std::uint32_t i = entries[e + kAhead];
    __builtin_prefetch(&list.items[i]);
    __builtin_prefetch(rects + i);
    __builtin_prefetch(outlines + i);
    const auto* record = reinterpret_cast<const char*>(&list.records[i]);
    for (std::size_t k = 0; k < sizeof(PixelRecord<Degree>); k += kLine) __builtin_prefetch(record + k);
}

/// Stage 1 of a tile: its surfels, nearest first, until the rest are hidden.
template <int Degree>
void run_stage_1(const DrawList<Degree>& list, std::span<const std::uint32_t> entries,
                 const TileSums& sums, TileBuffers& t) {
    constexpr std::size_t kLookEvery = 8;
    float far = std::numeric_limits<float>::infinity();
    for (std::size_t e = 0; e < entries.size(); ++e) {
        const std::uint32_t i = entries[e];
        const DrawItem& item = list.items[i];
        fetch_surfel(list, list.trimmed_outline.get(), list.trimmed.data(), entries, e);
        if (e % kLookEvery == kLookEvery - 1) far = t.farthest();
        if (t.depths.at(item.near_hit) > far) return;
        const auto entry = static_cast<float>(e);
        if (item.general != kFast)
            draw_first_general<Degree>(list.general[item.general], item.rims, list.trimmed[i], entry, sums, t);
        else
            draw_first<Degree>(list.records[i], item, list.trimmed[i], list.trimmed_outline[i], entry, sums, t);
    }
}

/// Stage 2 of a tile: its surfels that reach what is seen.
template <int Degree, bool kWantHessian, bool kSharpModel, bool kWantThird>
void run_stage_2(const DrawList<Degree>& list, std::span<const std::uint32_t> entries,
                 const TileSums& sums, TileBuffers& t) {
    if (!t.bound_hits()) return;
    for (std::size_t e = 0; e < entries.size(); ++e) {
        const std::uint32_t i = entries[e];
        const DrawItem& item = list.items[i];
        fetch_surfel(list, list.full_outline.get(), list.full.data(), entries, e);
        if (t.depths.at(item.near_blend) > t.far || t.depths.at(item.far_blend) < t.near) continue;
        if (item.general != kFast)
            draw_blend_general<Degree, kWantHessian, kSharpModel, kWantThird>(list.general[item.general], item.rims,
                                                                              list.full[i], sums, t);
        else
            draw_blend<Degree, kWantHessian, kSharpModel, kWantThird>(list.records[i], item, list.full[i],
                                                                      list.full_outline[i], sums, t);
    }
}

}  // namespace slim
