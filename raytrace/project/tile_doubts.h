#pragma once

#include "raytrace/project/ball_reach.h"
#include "raytrace/project/general_stages.h"
#include "raytrace/project/picked_pixels.h"
#include "raytrace/project/tile_stage_1.h"
#include "raytrace/project/tile_stage_2.h"
#include "slim/blend/blend.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// A surfel of a tile whose ball may hold points of picked pixels' rays.
struct NearPicked {
    std::uint32_t entry;     ///< in the tile's list
    BlockMask blocks, core;  ///< that its ball may touch, and the core of its ball
};

/// How large tau is in a ball: 1 / (1 - kappa), kappa no more than a quarter (others are general),
/// and a little.
constexpr float kReach = 1.35f;

/// Those of a tile's entries, in their order.
template <int Degree>
std::vector<NearPicked> near_picked(const PixelView& view, const DrawList<Degree>& list,
                                    std::span<const std::uint32_t> entries,
                                    const PickedPixels& picked) {
    std::vector<NearPicked> near;
    near.reserve(entries.size());
    for (std::uint32_t e = 0; e < entries.size(); ++e) {
        const Footprint& f = list.whole[entries[e]];
        const bool is_fast = list.items[entries[e]].general == kFast;
        if (!is_fast) {
            near.push_back({e, picked.all(), picked.all()});
            continue;
        }
        const float kappa = list.items[entries[e]].kappa;
        const BallDisc ball(view, f, kappa), core(view, f, kappa, static_cast<float>(kHitTrim));
        const float x = ball.x - static_cast<float>(picked.t.x0),
                    y = ball.y - static_cast<float>(picked.t.y0);
        const BlockMask blocks = picked.within(x, y, ball.reach);
        if (blocks.any()) near.push_back({e, blocks, picked.within(x, y, core.reach)});
    }
    return near;
}

/// visit(surfel, item, depth scale) for some surfels, in their order.
template <int Degree, class Visit>
void for_each_near(const DrawList<Degree>& list, std::span<const std::uint32_t> entries,
                   std::span<const NearPicked> near, const TileDepths& tile_depths,
                   Visit&& visit) {
    DepthBatch depths;
    for (std::size_t begin = 0; begin < near.size(); begin += kLanes) {
        const std::size_t end = std::min(begin + kLanes, near.size());
        for (std::size_t k = begin; k < end; ++k) {
            const DrawItem& item = list.items[entries[near[k].entry]];
            depths.set(k - begin, item.z_center, static_cast<double>(item.radius), item.near_hit,
                       item.far_blend);
        }
        depths.find(tile_depths);
        for (std::size_t k = begin; k < end; ++k)
            visit(near[k], list.items[entries[near[k].entry]], depths.scale(k - begin));
    }
}

/// visit(record, rim, base, block) for all blocks of picked pixels, of a surfel that the general
/// kernels draw. base: zeta of its record's b0.
template <int Degree, class Visit>
[[gnu::always_inline]] inline void for_each_picked(const DrawList<Degree>& list,
                                                   const DrawItem& item,
                                                   const PickedPixels& picked, Visit&& visit) {
    const SharpRecord& s = list.general[item.general];
    const auto base = static_cast<float>(s.sheet[0].z_base - picked.t.depths.z_ref);
    const RimLanes rim(item.rims);
    for (int block = 0; block < picked.n_blocks(); ++block) visit(s, rim, base, block);
}

/// Of some blocks of picked pixels those with a hit as deep as a surfel's ball.
inline BlockMask at_depth(const PickedPixels& picked, const BlockMask& blocks,
                          const DepthScale& scale) {
    const float reach = kReach * scale.per_tau;
    BlockMask left;
    for (int block = 0; block < picked.n_blocks(); ++block)
        if (blocks.has(block) && picked.has_hit_between(block, scale.zeta_c - reach,
                                                        scale.zeta_c + reach))
            left.add(static_cast<std::size_t>(block), 1);
    return left;
}

/// Adds the weights of rays that pass over a surfel at q^ (passing_weight in slim/blend).
template <int Degree, bool kSharpModel>
[[gnu::flatten, gnu::noinline]] void pass_over(const SurfelOnTile<Degree>& surfel, int block,
                                               TileBuffers& t) {
    constexpr float kFarthest = static_cast<float>(kBelongs), kSqFarthest = kFarthest * kFarthest;
    const PixelRecord<Degree>& r = surfel.record;
    const auto i = static_cast<std::size_t>(block * kLanes);
    const auto row = surfel.row_of(t.places, block, 1);
    const FloatV s = surfel.s_of(t.places, block), guess = surfel.depth.tau_of(t.z.load(i));
    const BallLanes<FloatV> ball = row.ball(s), around = about(ball, guess);
    t.counts.distance_tests += kLanes;
    const auto inside = around.n < 0.0f;
    if (stdx::none_of(inside)) return;
    const PolynomialLanes<FloatV> f = about(row.polynomial(s), guess);
    const auto above = inside && f[0] > 0.0f;
    if (stdx::none_of(above)) return;
    t.counts.root_tests += kLanes;
    const auto root =
        nearest_in_ball<Degree, FloatV>(f, around, BlendWork<Degree>(surfel).reach, above);
    const FloatV heights = row.height(guess + root.t) * row.height(guess);
    const FloatV sq_gap = root.t * root.t * (ball.l + r.kappa * (ball.m + r.kappa * ball.n));
    const auto near = root.hit && sq_gap <= kSqFarthest * (heights * heights);
    const FloatV share = row.share(guess);
    FloatV rim_share(1.0f);
    if (!surfel.rim.is_whole) {
        const auto [u, v] = row.plane(s, guess, share);
        rim_share = surfel.rim.share(u, v);
    }
    const auto passed =
        above && !near && admitted<kSharpModel>(row.gradient(s, guess, share), i, t);
    add_passing(t, i, passed, rim_share, 1.0f + around.n * (share * share));
}

/// Fills `passing` of pixels in doubt.
template <int Degree, bool kSharpModel>
void find_passing(const DrawList<Degree>& list, std::span<const std::uint32_t> entries,
                  std::span<const NearPicked> near, PickedPixels& picked) {
    TileBuffers& t = picked.t;
    picked.find_depths();
    for_each_near(list, entries, near, t.depths,
                  [&](const NearPicked& one, const DrawItem& item, const DepthScale& scale) {
        const std::uint32_t i = entries[one.entry];
        if (item.general != kFast)
            return for_each_picked(list, item, picked, [&](const SharpRecord& s, const auto& rim,
                                                           float base, int block) {
                pass_general<Degree, kSharpModel>(s, rim, base, block, t);
            });
        const BlockMask left = at_depth(picked, one.blocks, scale);
        if (!left.any()) return;
        const SurfelOnTile<Degree> surfel(list.records[i], item, list.whole[i], scale, t);
        for (int block = 0; block < picked.n_blocks(); ++block)
            if (left.has(block)) pass_over<Degree, kSharpModel>(surfel, block, t);
    });
}

/// Stage 1 of pixels that are looked at behind what was outvoted.
template <int Degree>
[[gnu::flatten]] void first_behind(const DrawList<Degree>& list,
                                   std::span<const std::uint32_t> entries,
                                   std::span<const NearPicked> near, const TileSums& sums,
                                   PickedPixels& picked) {
    TileBuffers& t = picked.t;
    const float near_plane = t.depths.at(0);
    for_each_near(list, entries, near, t.depths,
                  [&](const NearPicked& one, const DrawItem& item, const DepthScale& scale) {
        const std::uint32_t entry = entries[one.entry];
        const auto number = static_cast<float>(one.entry);
        if (item.general != kFast)
            return for_each_picked(list, item, picked, [&](const SharpRecord& s, const auto& rim,
                                                           float base, int block) {
                first_general_hits<Degree, true>(s, rim, number, base, block, sums, t);
            });
        if (scale.zeta_c + kReach * scale.per_tau < picked.least_last_z()) return;
        const FirstWork<Degree> work(
            SurfelOnTile<Degree>(list.records[entry], item, list.core[entry], scale, t), 0,
            near_plane, number);
        for (int block = 0; block < picked.n_blocks(); ++block) {
            const auto i = static_cast<std::size_t>(block * kLanes);
            if (!one.core.has(block)) continue;
            const FloatV least =
                stdx::max(FloatV(work.range.least), scale.tau_of(t.last_z.load(i)) +
                                                        static_cast<float>(kNextHit));
            t.counts.root_tests += kLanes;
            first_hits<Degree>(work.surfel, work.surfel.row_of(t.places, block, kSqTrim),
                               work.surfel.s_of(t.places, block), i, least, work.range.most,
                               number, sums, t);
        }
    });
}

/// Stage 2 of the same.
template <int Degree, bool kWantHessian, bool kSharpModel, bool kWantThird>
void blend_behind(const DrawList<Degree>& list, std::span<const std::uint32_t> entries,
                  std::span<const NearPicked> near, const TileSums& sums, PickedPixels& picked) {
    TileBuffers& t = picked.t;
    picked.find_depths();
    BlockBatch<BlendWork<Degree>> batch;
    const auto flush = [&] {
        draw_blend<Degree, kWantHessian, kSharpModel, kWantThird>(batch, sums, t);
        batch.clear();
    };
    for_each_near(list, entries, near, t.depths,
                  [&](const NearPicked& one, const DrawItem& item, const DepthScale& scale) {
        const std::uint32_t i = entries[one.entry];
        if (item.general != kFast) {
            flush();
            return for_each_picked(list, item, picked, [&](const SharpRecord& s, const auto& rim,
                                                           float base, int block) {
                blend_general<Degree, kWantHessian, kSharpModel, kWantThird>(s, rim, base, block,
                                                                             sums, t);
            });
        }
        const BlockMask left = at_depth(picked, one.blocks, scale);
        if (!left.any()) return;
        batch.add(BlendWork<Degree>(
                      SurfelOnTile<Degree>(list.records[i], item, list.whole[i], scale, t),
                      list.hessians.data() + (kWantHessian ? i : 0)),
                  left);
        if (batch.full()) flush();
    });
    flush();
}

/// Hits of a tile in doubt that are outvoted give way to what lies behind them, as often as that is
/// outvoted as well (raytrace/project/notes/0011). After stage 2.
template <int Degree, bool kWantHessian, bool kSharpModel, bool kWantThird>
void settle_doubts(const PixelView& view, const DrawList<Degree>& list,
                   std::span<const std::uint32_t> entries, const TileSums& sums, TileBuffers& t) {
    PickedPixels picked(view, t);
    if (picked.n_blocks() == 0) return;
    auto near = near_picked(view, list, entries, picked);
    for (int round = 0; round < kMostOutvoted; ++round) {
        find_passing<Degree, kSharpModel>(list, entries, near, picked);
        if (!picked.leave_outvoted(sums)) break;
        near = near_picked(view, list, entries, picked);
        first_behind<Degree>(list, entries, near, sums, picked);
        blend_behind<Degree, kWantHessian, kSharpModel, kWantThird>(list, entries, near, sums,
                                                                    picked);
        picked.put_back(sums, t);
    }
    t.counts.root_tests += picked.t.counts.root_tests;
    t.counts.distance_tests += picked.t.counts.distance_tests;
}

}  // namespace slim
