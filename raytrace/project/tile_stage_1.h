#pragma once

#include "raytrace/project/general_stages.h"
#include "raytrace/project/surfel_on_tile.h"
#include "slim/model/surfel.h"

#include <cstdint>
#include <span>

namespace slim {

/// Bounds of the roots that count.
struct TauRange {
    float least, most;
};

/// Stage 1 of some pixels: first root inside the shrunken ball, kept if nearer. Least: what bounds
/// the roots from below, a float or one per lane.
template <int Degree, class Least>
[[gnu::always_inline]] inline void first_hits(const SurfelOnTile<Degree>& surfel,
                                              const RowOf<Degree, FloatV>& row, const FloatV& s,
                                              std::size_t i, const Least& least, float most,
                                              float entry, const TileSums& sums,
                                              TileBuffers& t) {
    const auto root = first_in_ball<Degree, FloatV>(row.polynomial(s), row.ball(s), most, least);
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

inline constexpr float kSqTrim = static_cast<float>(kHitTrim * kHitTrim);

/// A surfel in stage 1.
template <int Degree>
struct FirstWork {
    SurfelOnTile<Degree> surfel;
    float nearest;  ///< blocks all of which is nearer are passed over
    TauRange range;
    float entry;

    FirstWork(const SurfelOnTile<Degree>& on_tile, float at_nearest, float near_plane,
              float at_entry)
        : surfel(on_tile),
          nearest(at_nearest),
          // tau is below 1 / (1 / R - kappa) in the ball.
          range{(near_plane - surfel.depth.zeta_c) * surfel.depth.per_zeta,
                1 / (static_cast<float>(1 / kHitTrim) - surfel.kappa)},
          entry(at_entry) {}
};

/// Stage 1 of some surfels, nearest first.
template <int Degree>
[[gnu::flatten, gnu::noinline]] void draw_first(const BlockBatch<FirstWork<Degree>>& batch,
                                                const TileSums& sums, TileBuffers& t) {
    batch.for_each([&](const FirstWork<Degree>& work, int block) __attribute__((always_inline)) {
        const auto i = static_cast<std::size_t>(block * kLanes);
        if (stdx::none_of(t.z.load(i) > work.nearest)) {
            ++t.counts.blocks_passed;
            return;
        }
        t.counts.root_tests += kLanes;
        first_hits<Degree>(work.surfel, work.surfel.row_of(t.places, block, kSqTrim),
                           work.surfel.s_of(t.places, block), i, work.range.least, work.range.most,
                           work.entry, sums, t);
    });
}

/// Stage 1 of a tile: its surfels, nearest first, until the rest are hidden.
template <int Degree>
[[gnu::flatten]] void run_stage_1(const DrawList<Degree>& list,
                                  std::span<const std::uint32_t> entries, const TileSums& sums,
                                  TileBuffers& t) {
    TileSurfels<Degree> some;
    BlockBatch<FirstWork<Degree>> batch;
    const float near_plane = t.depths.at(0);
    float far = t.bound_pixels();
    const auto flush = [&] {
        draw_first<Degree>(batch, sums, t);
        batch.clear();
        far = t.bound_pixels();
    };
    for (std::size_t e = 0; e < entries.size(); ++e) {
        const std::size_t lane = e % kLanes;
        if (lane == 0)
            some.find(list, list.core.data(), entries, e, t, [](const DrawItem& item) {
                return DepthPair{item.near_hit - 1e-5 * static_cast<double>(item.radius),
                                 item.near_hit};
            });
        if (some.depths.second(lane) > far) {
            t.counts.surfels_cut_off += entries.size() - e;
            break;
        }
        const std::uint32_t i = entries[e];
        const DrawItem& item = list.items[i];
        const auto entry = static_cast<float>(e);
        if (item.general != kFast) {
            flush();
            draw_first_general<Degree>(list.general[item.general], item.rims, list.core[i].rect,
                                       t.beyond(some.depths.first(lane)), entry, sums, t);
            continue;
        }
        const float nearest = some.depths.first(lane);
        BlockMask blocks = some.spans.blocks(lane);
        const int n_blocks = blocks.count();
        blocks &= t.beyond(nearest);
        t.counts.blocks_passed += static_cast<std::uint64_t>(n_blocks - blocks.count());
        if (!blocks.any()) continue;
        const SurfelOnTile<Degree> surfel(list.records[i], item, list.core[i],
                                          some.depths.scale(lane), t);
        batch.add(FirstWork<Degree>(surfel, nearest, near_plane, entry), blocks);
        if (batch.full()) flush();
    }
    flush();
}

}  // namespace slim
