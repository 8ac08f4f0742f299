#pragma once

#include "raytrace/project/general_stages.h"
#include "raytrace/project/surfel_on_tile.h"
#include "slim/model/surfel.h"

#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// Stage 2 of some pixels: eqs (6) and (7) around q^, with the gates of add_supporter (slim/blend).
template <int Degree, bool kWantHessian, bool kSharpModel, bool kWantThird>
[[gnu::always_inline]] inline void blend(const SurfelOnTile<Degree>& surfel,
                                         const HessianRecord* hessian,
                                         const RowOf<Degree, FloatV>& row, const FloatV& s,
                                         std::size_t i, float reach, const TileSums& sums,
                                         TileBuffers& t) {
    constexpr float kFarthest = static_cast<float>(kBelongs), kSqFarthest = kFarthest * kFarthest;
    const PixelRecord<Degree>& r = surfel.record;
    const FloatV guess = surfel.depth.tau_of(t.z.load(i));
    const BallLanes<FloatV> ball = row.ball(s), around = about(ball, guess);
    t.counts.distance_tests += kLanes;
    const auto inside = around.n < 0.0f;
    if (stdx::none_of(inside)) return;
    t.counts.root_tests += kLanes;
    const auto root =
        nearest_in_ball<Degree, FloatV>(about(row.polynomial(s), guess), around, reach, inside);
    const FloatV tau = guess + root.t, share = row.share(tau);
    // |q - q^|^2 (h h^)^2, from the ball's function where h = 0: the ray's point at infinity.
    const FloatV heights = row.height(tau) * row.height(guess);
    const FloatV sq_gap = root.t * root.t * (ball.l + r.kappa * (ball.m + r.kappa * ball.n));
    const auto g = row.gradient(s, tau, share);
    auto taken =
        root.hit && sq_gap <= kSqFarthest * (heights * heights) && admitted<kSharpModel>(g, i, t);
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
                    const auto [u, v] = row.plane(s, tau, share);
                    const auto h = hessian_from<FloatV>(*hessian, hessian->p.at(u, v));
                    for (std::size_t n = 0; n < 6; ++n) t.hessian[n].add(i, w * h[n]);
                    if constexpr (!kWantThird) return;
                    const auto c = third_of(r);
                    for (std::size_t n = 0; n < 10; ++n) t.third[n].add(i, w * c[n]);
                });
}

/// A surfel in stage 2.
template <int Degree>
struct BlendWork {
    SurfelOnTile<Degree> surfel;
    const HessianRecord* hessian;  ///< only where it is wanted
    float reach;

    explicit BlendWork(const SurfelOnTile<Degree>& on_tile, const HessianRecord* at = nullptr)
        : surfel(on_tile),
          hessian(at),
          // |dq/dtau| is at least 1 / h^2, and h at most 1 / (1 - kappa).
          reach(1.001f * static_cast<float>(kBelongs) / ((1 - surfel.kappa) * (1 - surfel.kappa))) {
    }
};

/// Stage 2 of some surfels.
template <int Degree, bool kWantHessian, bool kSharpModel, bool kWantThird>
[[gnu::flatten, gnu::noinline]] void draw_blend(const BlockBatch<BlendWork<Degree>>& batch,
                                                const TileSums& sums, TileBuffers& t) {
    batch.for_each([&](const BlendWork<Degree>& work, int block) __attribute__((always_inline)) {
        blend<Degree, kWantHessian, kSharpModel, kWantThird>(
            work.surfel, work.hessian, work.surfel.row_of(t.places, block, 1),
            work.surfel.s_of(t.places, block), static_cast<std::size_t>(block * kLanes), work.reach,
            sums, t);
    });
}

/// Entries of a tile that reach something seen, in their order.
inline std::vector<std::uint32_t> reaching(std::span<const DrawItem> items,
                                           std::span<const std::uint32_t> entries,
                                           const TileBuffers& t) {
    const double near = t.depths.z_of(t.near), far = t.depths.z_of(t.far);
    std::vector<std::uint32_t> out(entries.size());
    std::size_t n = 0;
    for (const std::uint32_t i : entries) {
        out[n] = i;  // no branch: there is no telling
        n += static_cast<std::size_t>((items[i].near_blend <= far) & (items[i].far_blend >= near));
    }
    out.resize(n);
    return out;
}

/// Stage 2 of a tile: its surfels that reach what is seen.
template <int Degree, bool kWantHessian, bool kSharpModel, bool kWantThird>
[[gnu::flatten]] void run_stage_2(const DrawList<Degree>& list,
                                  std::span<const std::uint32_t> entries, const TileSums& sums,
                                  TileBuffers& t) {
    if (!t.bound_hits()) return;
    TileSurfels<Degree> some;
    BlockBatch<BlendWork<Degree>> batch;
    const auto flush = [&] {
        draw_blend<Degree, kWantHessian, kSharpModel, kWantThird>(batch, sums, t);
        batch.clear();
    };
    const std::vector<std::uint32_t> left = reaching(list.items.span(), entries, t);
    t.counts.surfels_cut_off += entries.size() - left.size();
    for (std::size_t e = 0; e < left.size(); ++e) {
        const std::size_t lane = e % kLanes;
        if (lane == 0)
            some.find(list, list.whole.data(), left, e, t, [](const DrawItem& item) {
                return DepthPair{item.near_blend, item.far_blend};
            });
        const std::uint32_t i = left[e];
        const DrawItem& item = list.items[i];
        if (item.general != kFast) {
            flush();
            draw_blend_general<Degree, kWantHessian, kSharpModel, kWantThird>(
                list.general[item.general], item.rims, list.whole[i].rect,
                t.within(some.depths.first(lane), some.depths.second(lane)), sums, t);
            continue;
        }
        BlockMask blocks = some.spans.blocks(lane);
        const int n_blocks = blocks.count();
        blocks &= t.within(some.depths.first(lane), some.depths.second(lane));
        t.counts.blocks_passed += static_cast<std::uint64_t>(n_blocks - blocks.count());
        if (!blocks.any()) continue;
        const SurfelOnTile<Degree> surfel(list.records[i], item, list.whole[i],
                                          some.depths.scale(lane), t);
        batch.add(BlendWork<Degree>(surfel, list.hessians.data() + (kWantHessian ? i : 0)), blocks);
        if (batch.full()) flush();
    }
    flush();
}

}  // namespace slim
