#include "raytrace/project/tile_blocks.h"

#include <gtest/gtest.h>

namespace slim {
namespace {

TEST(TileBlocks, LanesStandWhereTheirPixelsDo) {
    const PixelPlaces places;
    for (int block = 0; block < kTileBlocks; ++block) {
        const FloatV x = places.column(block), y = places.row(block);
        for (std::size_t k = 0; k < FloatV::size(); ++k) {
            const int column = static_cast<int>(x[k]), row = static_cast<int>(y[k]);
            ASSERT_TRUE(column >= 0 && column < kTileSize && row >= 0 && row < kTileSize)
                << block << ' ' << k;
            ASSERT_EQ(pixel_entry(column, row), static_cast<std::size_t>(block * kLanes) + k)
                << block << ' ' << k;
        }
    }
}

}  // namespace
}  // namespace slim
