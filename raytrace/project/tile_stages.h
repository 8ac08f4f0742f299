#pragma once

#include "raytrace/intersect/pixel_kernel.h"
#include "raytrace/project/block_spans.h"
#include "raytrace/project/depth_batch.h"
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
#include <type_traits>
#include <vector>

namespace slim {

// What works on a surfel's lanes is one function, flattened, and all it calls is always inline: g++
// 12 leaves out some calls as kernels grow, and passes the lanes through memory.

/// One surfel on one tile.
template <int Degree>
struct SurfelOnTile {
    using Row = RowOf<Degree, FloatV>;
    const PixelRecord<Degree>& record;
    RimLanes rim;
    DepthScale depth;
    float kappa;
    float x, y;  ///< of the tile, from the record's own pixel: whole numbers, s and t to the last
                 ///< bit wherever the tile begins

    /// Reads nothing of the record yet.
    SurfelOnTile(const PixelRecord<Degree>& r, const DrawItem& item, const Footprint& f,
                 const DepthScale& scale, const TileBuffers& t)
        : record(r),
          rim(item.rims),
          depth(scale),
          kappa(item.kappa),
          x(static_cast<float>(t.x0) - f.pixel_x),
          y(static_cast<float>(t.y0) - f.pixel_y) {
        constexpr std::size_t kLine = 64;
        const auto* line = reinterpret_cast<const char*>(&record);
        for (std::size_t k = 0; k < sizeof record; k += kLine) __builtin_prefetch(line + k);
    }

    [[gnu::always_inline]] FloatV s_of(int block) const {
        return (tile_columns(block) + x) * record.step + record.base_x;
    }
    /// sq_radius is that of the ball.
    [[gnu::always_inline]] Row row_of(int block, float sq_radius) const {
        return Row(record, (tile_rows(block) + y) * record.step + record.base_y, sq_radius);
    }
};

/// What is to be done on a tile next: some surfels, and the blocks of each.
template <class Work>
class BlockBatch {
public:
    BlockBatch() {}
    bool full() const { return n_ == BlockList::kMostSurfels; }
    void clear() { n_ = 0, list_.clear(); }
    /// Not when full.
    void add(const Work& work, const BlockMask& blocks) {
        new (work_ + n_) Work(work);
        list_.add(n_++, blocks);
    }
    /// visit(work, block): surfels in their order.
    template <class Visit>
    [[gnu::always_inline]] void for_each(Visit&& visit) const {
        for (int k = 0; k < list_.size(); ++k) visit(work_[list_.surfel(k)], list_.block(k));
    }

private:
    static_assert(std::is_trivially_destructible_v<Work>);
    int n_ = 0;
    BlockList list_;
    union {  // keeps what it holds from being set beforehand
        Work work_[BlockList::kMostSurfels];
    };
};

/// Bounds of the roots that count.
struct TauRange {
    float least, most;
};

/// Stage 1 of some pixels: first root inside the shrunken ball, kept if nearer.
template <int Degree>
[[gnu::always_inline]] inline void first_hits(const SurfelOnTile<Degree>& surfel,
                                              const RowOf<Degree, FloatV>& row, const FloatV& s,
                                              std::size_t i, const TauRange& range, float entry,
                                              const TileSums& sums, TileBuffers& t) {
    const auto root =
        first_in_ball<Degree, FloatV>(row.polynomial(s), row.ball(s), range.most, range.least);
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
        first_hits<Degree>(work.surfel, work.surfel.row_of(block, kSqTrim), work.surfel.s_of(block),
                           i, work.range, work.entry, sums, t);
    });
}

/// Stage 2 of some pixels: eqs (6) and (7) around q^, with the gates of add_supporter (slim/blend).
template <int Degree, bool kWantHessian, bool kSharpModel, bool kWantThird>
[[gnu::always_inline]] inline void blend(const SurfelOnTile<Degree>& surfel,
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
                    const auto at = row.plane(s, tau, share);
                    for (std::size_t n = 0; n < 6; ++n) t.hessian[n].add(i, w * row.hessian(n, at));
                    if constexpr (!kWantThird) return;
                    const auto c = third_of(r);
                    for (std::size_t n = 0; n < 10; ++n) t.third[n].add(i, w * c[n]);
                });
}

/// A surfel in stage 2.
template <int Degree>
struct BlendWork {
    SurfelOnTile<Degree> surfel;
    float reach;

    explicit BlendWork(const SurfelOnTile<Degree>& on_tile)
        : surfel(on_tile),
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
            work.surfel, work.surfel.row_of(block, 1), work.surfel.s_of(block),
            static_cast<std::size_t>(block * kLanes), work.reach, sums, t);
    });
}

/// Some surfels of a tile, as many as there are lanes: where they are on it.
template <int Degree>
struct TileSurfels {
    BlockSpans spans;
    DepthBatch depths;

    /// Those of the tile's entries from some on. depths_of(item): the further depths. Asks for what
    /// the next ones need.
    template <class DepthsOf>
    [[gnu::always_inline]] void find(const DrawList<Degree>& list, const Footprint* footprints,
                                     std::span<const std::uint32_t> entries, std::size_t begin,
                                     const TileBuffers& t, const DepthsOf& depths_of) {
        const std::size_t end = std::min(begin + kLanes, entries.size()),
                          n = std::min(end + kLanes, entries.size());
        for (std::size_t e = end; e < n; ++e) {
            __builtin_prefetch(&list.items[entries[e]]);
            __builtin_prefetch(footprints + entries[e]);
        }
        for (std::size_t e = begin; e < end; ++e) {
            const DrawItem& item = list.items[entries[e]];
            const auto [first, second] = depths_of(item);
            spans.set(e - begin, footprints[entries[e]]);
            depths.set(e - begin, item.z_center, static_cast<double>(item.radius), first, second);
        }
        spans.find(t);
        depths.find(t.depths);
    }
};

/// Two depths of a surfel.
struct DepthPair {
    double first, second;
};

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
                                       entry, sums, t);
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
                list.general[item.general], item.rims, list.whole[i].rect, sums, t);
            continue;
        }
        BlockMask blocks = some.spans.blocks(lane);
        const int n_blocks = blocks.count();
        blocks &= t.within(some.depths.first(lane), some.depths.second(lane));
        t.counts.blocks_passed += static_cast<std::uint64_t>(n_blocks - blocks.count());
        if (!blocks.any()) continue;
        const SurfelOnTile<Degree> surfel(list.records[i], item, list.whole[i],
                                          some.depths.scale(lane), t);
        batch.add(BlendWork<Degree>(surfel), blocks);
        if (batch.full()) flush();
    }
    flush();
}

}  // namespace slim
