#pragma once

#include "raytrace/lines/bit_rows.h"
#include "raytrace/lines/line_scene.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace slim {

/// What neighbours are to each other, for pixel and next pixel of a row,
/// or pixel and the one below.
struct SheetEdges {
    BitRows unbroken;  ///< both hit, and not breaks_off
    BitRows joined;    ///< one_sheet
    BitRows creased;   ///< unbroken, and N turns by 30 degrees or more: an edge within the pixel
};

/// How many pixels to every side a blur averages: 3 in a picture 1000 high, in proportion.
std::size_t blur_reach(int picture_width, int picture_height);

/// Where the sheets of a view end, looked up once for all kinds of lines. cost O(pixels), in lanes,
/// parallel by rows
struct Sheets {
    explicit Sheets(const LineScene& scene);

    const SheetEdges& to(bool below) const { return below ? down : right; }
    /// Bits of the pairs of pixels x, x + 1, ... of row y with the next or the one below that lie
    /// in the picture.
    std::uint32_t pairs(bool below, std::size_t y, std::size_t x) const {
        if (below) return y + 1 < height ? kAllLanes : 0;
        return x + kLanes < width ? kAllLanes : (1u << (width - 1 - x)) - 1;
    }

    std::size_t width, height;
    std::size_t reach;  ///< blur_reach of the picture, and the bits' margins
    BitRows hit;
    SheetEdges right, down;
};

}  // namespace slim
