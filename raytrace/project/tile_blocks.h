#pragma once

#include "raytrace/project/tile_bins.h"
#include "slim/base/simd.h"

#include <bit>
#include <cstddef>

namespace slim {

/// A group of lanes is a block of pixels, as square as may be: a disc of a few pixels touches fewer
/// of them than of rows. A tile holds its pixels block by block, a block's row by row.
inline constexpr int kBlockWidth = 4, kBlockHeight = kLanes / kBlockWidth;
inline constexpr int kBlockColumns = kTileSize / kBlockWidth, kBlockRows = kTileSize / kBlockHeight;
inline constexpr std::size_t kTilePixels = static_cast<std::size_t>(kTileSize) * kTileSize;
static_assert(kLanes % kBlockWidth == 0 && kTileSize % kBlockHeight == 0 &&
              kTileSize % kBlockWidth == 0);

inline constexpr int kTileBlocks = kBlockColumns * kBlockRows;
static_assert(kTileBlocks <= 256);

/// First entry of a block in a tile's planes.
constexpr std::size_t block_start(int row, int column) {
    return static_cast<std::size_t>((row * kBlockColumns + column) * kLanes);
}
/// Entry of pixel (x, y) of a tile.
constexpr std::size_t pixel_entry(int x, int y) {
    return block_start(y / kBlockHeight, x / kBlockWidth) +
           static_cast<std::size_t>(y % kBlockHeight * kBlockWidth + x % kBlockWidth);
}

/// Columns and rows of the lanes in their block.
inline FloatV lane_columns() {
    return FloatV([](auto k) { return static_cast<float>(static_cast<int>(k) % kBlockWidth); });
}
inline FloatV lane_rows() {
    return FloatV([](auto k) { return static_cast<float>(static_cast<int>(k) / kBlockWidth); });
}

/// Columns and rows of every block's lanes in their tile: a load instead of a number made a float
/// and spread to the lanes.
struct alignas(64) LanePlaces {
    float column[kBlockColumns][kLanes], row[kBlockRows][kLanes];
};
inline constexpr LanePlaces kLanePlaces = [] {
    LanePlaces places{};
    for (int k = 0; k < kLanes; ++k) {
        for (int c = 0; c < kBlockColumns; ++c)
            places.column[c][k] = static_cast<float>(c * kBlockWidth + k % kBlockWidth);
        for (int r = 0; r < kBlockRows; ++r)
            places.row[r][k] = static_cast<float>(r * kBlockHeight + k / kBlockWidth);
    }
    return places;
}();
static_assert((kBlockColumns & (kBlockColumns - 1)) == 0);
inline constexpr int kBlockRowShift = std::countr_zero(static_cast<unsigned>(kBlockColumns));

/// Where the lanes of some blocks are, counted from a tile's first pixel: those of a whole tile, or
/// picked ones (PickedPixels).
struct PixelPlaces {
    const float* columns = kLanePlaces.column[0];
    const float* rows = kLanePlaces.row[0];
    int column_mask = kBlockColumns - 1, row_shift = kBlockRowShift;

    /// Those of a block's lanes.
    [[gnu::always_inline]] const float* columns_of(int block) const {
        return columns + (block & column_mask) * kLanes;
    }
    [[gnu::always_inline]] const float* rows_of(int block) const {
        return rows + (block >> row_shift) * kLanes;
    }
    [[gnu::always_inline]] FloatV column(int block) const {
        return FloatV(columns_of(block), stdx::vector_aligned);
    }
    [[gnu::always_inline]] FloatV row(int block) const {
        return FloatV(rows_of(block), stdx::vector_aligned);
    }
};

}  // namespace slim
