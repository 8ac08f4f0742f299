#include "slim/cover/point_raster.h"

#include <gtest/gtest.h>

#include <cstddef>

namespace slim::test {
namespace {

CellMask square(std::size_t n, std::size_t x0, std::size_t y0, std::size_t size) {
    CellMask out;
    out.n = n;
    for (std::size_t y = y0; y < y0 + size; ++y)
        for (std::size_t x = x0; x < x0 + size; ++x) out.set(x, y);
    return out;
}

TEST(CellMask, WhatSquaresFillIsLeft) {
    for (const std::size_t n : {16u, 64u}) {
        SCOPED_TRACE(n);
        CellMask m = square(n, n - 7, 5, 7);  // up to the last column
        m.set(2, 2);
        EXPECT_EQ(m.count(), 50u);
        for (std::size_t size = 2; size <= 7; ++size) {
            EXPECT_EQ(m.corners_of_squares(size).count(), (8 - size) * (8 - size)) << size;
            EXPECT_EQ(m.opened(size).count(), 49u) << size;
        }
        EXPECT_FALSE(m.opened(8).any());
        EXPECT_EQ(m.opened(1).count(), 50u);
        EXPECT_EQ(m.without(m.opened(2)).count(), 1u);
    }
}

TEST(CellMask, GrowsOnAllSidesWithinTheSquare) {
    CellMask m = square(20, 10, 3, 1);
    const CellMask grown = m.grown(4);
    EXPECT_EQ(grown.count(), 9u * 8u);  // a row is beyond the square
    EXPECT_TRUE(grown.at(6, 0));
    EXPECT_TRUE(grown.at(14, 7));
    EXPECT_FALSE(grown.at(15, 7));
    EXPECT_FALSE(grown.at(14, 8));
    EXPECT_FALSE(grown.at(20, 0));
}

TEST(PointRaster, ItsCellsHoldOnePointOnAverage) {
    const PointRaster raster(1000);
    const double n_cells = static_cast<double>(disc_of_cells(raster.cells(), 1).count());
    EXPECT_GT(n_cells, 800);  // those at the rim are not whole
    EXPECT_LT(n_cells, 1000);
    EXPECT_EQ(PointRaster(100000).cells(), 64u);
}

TEST(PointRaster, CoordinatesUpToOneHaveACell) {
    for (const std::size_t n : {100u, 1000u, 100000u}) {
        PointRaster raster(n);
        EXPECT_EQ(raster.cell_of(-1), 0u);
        EXPECT_EQ(raster.cell_of(1), raster.cells() - 1);
        const std::size_t i = raster.cells() / 3;
        EXPECT_EQ(raster.cell_of(static_cast<float>(raster.middle_of(i))), i);
    }
}

}  // namespace
}  // namespace slim::test
