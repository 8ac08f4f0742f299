#pragma once

#include "raytrace/lines/line_scene.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// How far the sheet goes around every pixel in one direction of the grid.
struct SheetWindows {
    std::size_t width = 0, stride = 1, reach = 1;
    std::vector<std::uint8_t> joined;  ///< on one sheet with the next pixel?
    std::vector<std::uint8_t> whole;   ///< with all `reach` pixels to both sides?
};

/// Averages planes over (2 r + 1)^2 pixels of the sheet around each hit, r = 3 in a picture 1000
/// pixels high and in proportion: along rows, then along columns, up to where the sheet ends
/// (one_sheet). cost  O(pixels x r), parallel over rows; the same for any number of threads A NaN
/// spoils the pixels around it. Where the sheets end is looked up once for all planes of a scene.
class SheetBlur {
public:
    explicit SheetBlur(const LineScene& scene);
    void operator()(std::span<std::vector<float>> planes) const;

private:
    std::array<SheetWindows, 2> along_;  ///< rows, columns
};

}  // namespace slim
