#pragma once

#include "raytrace/intersect/pixel_kernel.h"
#include "raytrace/project/block_spans.h"
#include "raytrace/project/depth_batch.h"
#include "raytrace/project/draw_list.h"
#include "raytrace/project/tile_buffers.h"
#include "raytrace/project/tile_lanes.h"

#include <algorithm>
#include <cstdint>
#include <new>
#include <span>
#include <type_traits>

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

    [[gnu::always_inline]] FloatV s_of(const PixelPlaces& places, int block) const {
        return (places.column(block) + x) * record.step + record.base_x;
    }
    /// sq_radius is that of the ball.
    [[gnu::always_inline]] Row row_of(const PixelPlaces& places, int block,
                                      float sq_radius) const {
        return Row(record, (places.row(block) + y) * record.step + record.base_y, sq_radius);
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

}  // namespace slim
