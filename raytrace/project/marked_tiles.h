#pragma once

#include "raytrace/project/screen_rect.h"
#include "raytrace/sample_mask.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace slim {

/// Which tiles of a grid hold a wanted sample, to ask of rectangles in constant time.
class MarkedTiles {
public:
    /// grid  in whole tiles
    /// cost  O(pixels of the mask's part)
    MarkedTiles(const SampleMask& mask, const PixelWindow& grid);

    /// Whether a tile that the rectangle touches does; the rectangle lies in the grid, not empty.
    bool any(const ScreenRect& r) const;

private:
    std::size_t at(std::size_t column, std::size_t row) const {
        return row * (columns_ + 1) + column;
    }

    int x_, y_;
    std::size_t columns_, rows_;
    std::vector<std::uint32_t> sums_;  ///< marked tiles above and to the left of each
};

}  // namespace slim
