#pragma once

#include "raytrace/intersect/pixel_kernel.h"
#include "raytrace/project/draw_list.h"
#include "raytrace/project/general_stages.h"
#include "raytrace/project/row_spans.h"
#include "raytrace/project/tile_buffers.h"
#include "raytrace/project/tile_lanes.h"
#include "slim/model/surfel.h"

#include <algorithm>
#include <cstdint>
#include <span>

namespace slim {

// What works on a surfel's lanes is one function, flattened, and all it calls is always inline: g++ 12 leaves out some calls as
// kernels grow, and passes the lanes through memory.

/// One surfel on one row of a tile.
template <int Degree>
struct SurfelRow {
    const PixelRecord<Degree>& record;
    const RowOf<Degree>& row;
    float base;  ///< depth of tau = 0, relative to the tile's
    FloatV x;    ///< pixels

    [[gnu::always_inline]] FloatV tau_of(const FloatV& z) const {
        return (z - FloatV(base)) * FloatV(record.inv_radius);
    }
    [[gnu::always_inline]] FloatV depth_of(const FloatV& tau) const {
        return FloatV(base) + FloatV(record.radius) * tau;
    }
};

/// Stage 1: first root inside the shrunken ball, kept if nearer. Returns whether any was.
template <int Degree>
[[gnu::always_inline]] inline bool first_hits(const SurfelRow<Degree>& at, const RimLanes& rim, float entry,
                                        std::size_t i, const TileSums& sums, TileBuffers& t) {
    constexpr float kSqTrim = static_cast<float>(kHitTrim * kHitTrim);
    const PixelRecord<Degree>& r = at.record;
    const FloatV s = pixel_offset<Degree, FloatV>(r, at.x);
    const auto ball = ball_lanes<Degree, FloatV>(r, at.row, s);
    const auto k = pixel_polynomial<Degree, FloatV>(r, at.row, s);
    const float nearest = (t.near_z - at.base) * r.inv_radius;
    const auto root = first_in_ball<Degree, FloatV>(k, ball, kSqTrim, nearest);
    const FloatV z = at.depth_of(root.t);
    auto nearer = root.hit && z < t.z.load(i);
    if (stdx::none_of(nearer)) return false;
    if (!rim.is_whole) {
        const auto [u, v] = plane_lanes<Degree, FloatV>(r, at.row, s, root.t);
        nearer = nearer && rim.share(u, v) > 0.0f;
    }
    keep_nearer(t, i, entry, nearer, z, pixel_gradient<Degree, FloatV>(r, at.row, s, root.t), sums);
    return true;
}

/// Stage 2: eqs (6) and (7) around q^, with the gates of add_supporter (slim/blend).
template <int Degree, bool kWantHessian, bool kSharpModel, bool kWantThird>
[[gnu::always_inline]] inline void blend(const SurfelRow<Degree>& at, const RimLanes& rim, std::size_t i,
                                   const TileSums& sums, TileBuffers& t) {
    constexpr float kFarthest = static_cast<float>(kBelongs);
    const PixelRecord<Degree>& r = at.record;
    const FloatV s = pixel_offset<Degree, FloatV>(r, at.x);
    const FloatV guess = at.tau_of(t.z.load(i));
    const auto around = about(ball_lanes<Degree, FloatV>(r, at.row, s), guess);
    t.counts.distance_tests += kLanes;
    const auto inside = around.n < 1.0f;
    if (stdx::none_of(inside)) return;
    t.counts.root_tests += kLanes;
    const auto k = about(pixel_polynomial<Degree, FloatV>(r, at.row, s), guess);
    const auto root = nearest_in_ball<Degree, FloatV>(k, around, kFarthest * 1.001f, inside);
    const FloatV tau = guess + root.t;
    const auto g = pixel_gradient<Degree, FloatV>(r, at.row, s, tau);
    auto taken = root.hit && root.t * root.t * around.l <= kFarthest * kFarthest &&
                 admitted<kSharpModel>(g, i, t);
    FloatV share(1.0f);
    if (!rim.is_whole) {
        const auto [u, v] = plane_lanes<Degree, FloatV>(r, at.row, s, tau);
        share = rim.share(u, v);
        taken = taken && share > 0.0f;
    }
    if (stdx::none_of(taken)) return;
    add_to_sums(t, i, taken, share, around.sq_distance(root.t), r.radius * root.t, g, sums,
                [&](const FloatV& w) __attribute__((always_inline)) {
                    if constexpr (!kWantHessian) return;
                    const auto [u, v] = plane_lanes<Degree, FloatV>(r, at.row, s, tau);
                    const auto h = hessian_at<Degree, FloatV>(r, u, v);
                    for (std::size_t n = 0; n < 6; ++n) t.hessian[n].add(i, w * h[n]);
                    if constexpr (!kWantThird) return;
                    const auto c = third_of(r);
                    for (std::size_t n = 0; n < 10; ++n) t.third[n].add(i, w * c[n]);
                });
}

/// Calls visit(y, x, strip) for the groups of lanes that cover a surfel's outline, row by row: as few as a row needs,
/// none overlapping another; and end_strip(strip) after the rows of a strip.
template <int Degree, class Visit, class EndStrip>
[[gnu::always_inline]] inline void for_each_span(const TileBuffers& t, const ScreenRect& r,
                                                 const PixelRecord<Degree>& record, float sq_radius, Visit&& visit,
                                                 EndStrip&& end_strip) {
    const ScreenRect& c = t.clip;
    const int y0 = std::max(r.y0, c.y0) - t.y0, y1 = std::min(r.y1, c.y1) - t.y0;
    const int x0 = std::max(r.x0, c.x0) - t.x0, x1 = std::min(r.x1, c.x1) - t.x0;
    if (x0 >= x1) return;
    RowSpans spans;
    if (x1 - x0 > kLanes) spans = row_spans(record, sq_radius, t, x0, x1);
    else spans.all(x0, x1);
    for (int y = y0; y < y1;) {
        const int strip = y / kStripRows, end = std::min(y1, (strip + 1) * kStripRows);
        for (; y < end; ++y) {
            const int n_groups = (spans.x1[y] - spans.x0[y] + kLanes - 1) / kLanes;
            const int first = std::min(spans.x0[y], kTileSize - n_groups * kLanes);
            for (int g = 0; g < n_groups; ++g) visit(y, first + g * kLanes, strip);
        }
        end_strip(strip);
    }
}

/// Stage 1 of one surfel; groups that lie behind what a strip already has are passed over.
template <int Degree>
[[gnu::flatten, gnu::noinline]] void draw_first(const PixelRecord<Degree>& r, const DrawItem& item,
                                                const ScreenRect& rect, float entry, const TileSums& sums,
                                                TileBuffers& t) {
    constexpr float kSqTrim = static_cast<float>(kHitTrim * kHitTrim);
    const auto base = static_cast<float>(item.z_base - t.z_ref);
    const float nearest = static_cast<float>(item.near_hit - t.z_ref) - 1e-5f * r.radius;
    const RimLanes rim(item.rims);
    const FloatV lane([](auto k) { return static_cast<float>(k); });
    bool changed = false;
    for_each_span<Degree>(t, rect, r, kSqTrim, [&](int y, int x, int strip) __attribute__((always_inline)) {
        const FloatV far(t.strip_far + strip * kTileSize + x, stdx::element_aligned);
        if (stdx::none_of(far > nearest)) return;
        const RowOf<Degree> row(r, static_cast<float>(t.y0 + y));
        t.counts.root_tests += kLanes;
        changed |= first_hits<Degree>({r, row, base, lane + static_cast<float>(t.x0 + x)}, rim, entry,
                                      static_cast<std::size_t>(y * kTileSize + x), sums, t);
    }, [&](int strip) __attribute__((always_inline)) {
        if (!changed) return;
        for (int x = 0; x < kTileSize; x += kLanes) t.update_strip(strip, x);
        changed = false;
    });
}

/// Stage 2 of one surfel; groups none of whose q^ is within its reach are passed over.
template <int Degree, bool kWantHessian, bool kSharpModel, bool kWantThird>
[[gnu::flatten, gnu::noinline]] void draw_blend(const PixelRecord<Degree>& r, const DrawItem& item,
                                                const ScreenRect& rect, const TileSums& sums, TileBuffers& t) {
    const auto base = static_cast<float>(item.z_base - t.z_ref);
    // A little more than its reach, for the rounding of the depths.
    const float near = static_cast<float>(item.near_blend - t.z_ref) - 1e-4f * r.radius;
    const float far = static_cast<float>(item.far_blend - t.z_ref) + 1e-4f * r.radius;
    const RimLanes rim(item.rims);
    const FloatV lane([](auto k) { return static_cast<float>(k); });
    for_each_span<Degree>(t, rect, r, 1, [&](int y, int x, int strip) __attribute__((always_inline)) {
        const FloatV hits_far(t.strip_far + strip * kTileSize + x, stdx::element_aligned);
        const FloatV hits_near(t.strip_near + strip * kTileSize + x, stdx::element_aligned);
        if (stdx::none_of(hits_far >= near && hits_near <= far)) return;
        const RowOf<Degree> row(r, static_cast<float>(t.y0 + y));
        blend<Degree, kWantHessian, kSharpModel, kWantThird>({r, row, base, lane + static_cast<float>(t.x0 + x)}, rim,
                                                             static_cast<std::size_t>(y * kTileSize + x), sums, t);
    }, [](int) __attribute__((always_inline)) {});
}

/// Stage 1 of a tile: its surfels, nearest first.
template <int Degree>
void run_stage_1(const DrawList<Degree>& list, std::span<const std::uint32_t> entries,
                 const TileSums& sums, TileBuffers& t) {
    for (std::size_t e = 0; e < entries.size(); ++e) {
        const std::uint32_t i = entries[e];
        const DrawItem& item = list.items[i];
        const auto entry = static_cast<float>(e);
        if (item.general == kFast) draw_first<Degree>(list.records[i], item, list.trimmed[i], entry, sums, t);
        else draw_first_general<Degree>(list.general[item.general], item.rims, list.trimmed[i], entry, sums, t);
    }
}

/// Stage 2 of a tile.
template <int Degree, bool kWantHessian, bool kSharpModel, bool kWantThird>
void run_stage_2(const DrawList<Degree>& list, std::span<const std::uint32_t> entries,
                 const TileSums& sums, TileBuffers& t) {
    if (!t.bound_hits()) return;
    for (const std::uint32_t i : entries) {
        const DrawItem& item = list.items[i];
        if (item.general == kFast)
            draw_blend<Degree, kWantHessian, kSharpModel, kWantThird>(list.records[i], item, list.full[i], sums, t);
        else
            draw_blend_general<Degree, kWantHessian, kSharpModel, kWantThird>(list.general[item.general], item.rims,
                                                                              list.full[i], sums, t);
    }
}

}  // namespace slim
