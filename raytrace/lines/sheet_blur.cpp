#include "raytrace/lines/sheet_blur.h"

#include "slim/base/parallel.h"

#include <algorithm>

namespace slim {

std::vector<float> blurred(const Sheets& sheets, const std::vector<float>& plane) {
    std::vector<float> out(plane.size());
    const std::size_t width = sheets.width;
    parallel_blocks(sheets.height, blur_band(sheets), [&](std::size_t begin, std::size_t end) {
        RowBlur<1> blur(sheets);
        blur.run(
            begin, end,
            [&](std::size_t y, std::size_t x) {
                return std::array<FloatV, 1>{lanes_at(plane, y * width + x)};
            },
            [&](std::size_t y, const auto& mean) {
                for (std::size_t x = 0; x < width; x += kLanes) {
                    if (sheets.hit.at(static_cast<std::ptrdiff_t>(y),
                                      static_cast<std::ptrdiff_t>(x)) == 0)
                        continue;
                    alignas(FloatV) std::array<float, kLanes> lanes;
                    mean(x)[0].copy_to(lanes.data(), stdx::vector_aligned);
                    std::copy_n(lanes.begin(), std::min<std::size_t>(kLanes, width - x),
                                out.begin() + static_cast<std::ptrdiff_t>(y * width + x));
                }
            });
    });
    return out;
}

}  // namespace slim
