#pragma once

#include "raytrace/camera.h"
#include "raytrace/project/block_mask.h"
#include "raytrace/project/tile_buffers.h"

#include <array>
#include <cstdint>

namespace slim {

/// Pixels of a tile whose hit is in doubt (is_in_doubt in slim/blend), close up: what is asked of
/// them is asked of few lanes, not of the tile's blocks.
class PickedPixels {
public:
    /// Their planes, of which `passing` and `last_z` belong to them alone: sum G of the surfels
    /// that their rays pass over at q^, and the zeta of a hit that was outvoted.
    TileBuffers t;

    /// Picks them from a tile after stage 2. Planes of derivatives are not set.
    PickedPixels(const PixelView& view, const TileBuffers& tile);

    int n_blocks() const { return (n_ + kLanes - 1) / kLanes; }
    /// Blocks with a pixel in a disc, counted from the tile's first pixel.
    BlockMask within(float x, float y, float radius) const;
    BlockMask all() const;
    /// The least zeta of what was outvoted.
    float least_last_z() const { return least_last_z_; }
    /// Blocks with a hit between two zetas, as of the last find_depths.
    bool has_hit_between(int block, float least, float most) const {
        const auto k = static_cast<std::size_t>(block);
        return near_[k] <= most && far_[k] >= least;
    }
    void find_depths();
    /// Leaves only pixels whose hit does not count (is_in_doubt, is_outvoted), to be looked
    /// at behind it: z and sums as before stage 1. Returns whether there are any; if not, all is
    /// left as it is.
    bool leave_outvoted(const TileSums& sums);
    /// Writes them to the tile.
    void put_back(const TileSums& sums, TileBuffers& tile) const;

private:
    int n_ = 0;
    alignas(64) std::array<float, kTilePixels> columns_, rows_;
    std::array<std::uint16_t, kTilePixels> entry_;  ///< in the tile's planes
    float least_last_z_ = 0;
    std::array<float, kTileBlocks> near_, far_;

    void pick(const TileBuffers& tile, std::size_t entry);
    void fill_directions(const PixelView& view);
    void move(std::size_t from, std::size_t to);
    /// No hits in the lanes beyond the last pixel.
    void fill_up();
};

}  // namespace slim
