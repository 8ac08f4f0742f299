#include "raytrace/lines/sheet_blur.h"

#include "slim/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace slim {
namespace {

constexpr double kReachAt1000 = 3;

/// Of every pixel whether it is on one sheet with the next in a direction.
std::vector<std::uint8_t> joined_with_next(const LineScene& s, bool down) {
    const auto width = static_cast<std::size_t>(s.buffer.width);
    const std::size_t n = s.buffer.n_pixels(), stride = down ? width : 1;
    std::vector<std::uint8_t> joined(n, 0);
    parallel_blocks(n, width, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            if (down ? i + width < n : i + 1 < end) joined[i] = one_sheet(s, i, i + stride);
    });
    return joined;
}

/// The mean over up to r pixels to either side, no farther than the sheet goes.
void blur_along(const LineScene& s, bool down, std::size_t reach,
                std::array<std::vector<float>, 3>& planes) {
    const auto width = static_cast<std::size_t>(s.buffer.width);
    const std::size_t stride = down ? width : 1;
    const std::vector<std::uint8_t> joined = joined_with_next(s, down);
    std::array<std::vector<float>, 3> out = planes;
    parallel_blocks(joined.size(), width, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!s.hit(i)) continue;
            Vec3f sum{planes[0][i], planes[1][i], planes[2][i]};
            float count = 1;
            const auto add = [&](std::size_t j) {
                sum += Vec3f{planes[0][j], planes[1][j], planes[2][j]};
                ++count;
            };
            std::size_t j = i;
            for (std::size_t k = 0; k < reach && joined[j]; ++k) add(j += stride);
            j = i;
            for (std::size_t k = 0; k < reach && j >= stride && joined[j - stride]; ++k) add(j -= stride);
            for (std::size_t axis = 0; axis < 3; ++axis) out[axis][i] = sum[axis] / count;
        }
    });
    planes = std::move(out);
}

}  // namespace

void blur_on_sheets(const LineScene& scene, std::array<std::vector<float>, 3>& planes) {
    const double size = std::min(scene.buffer.width, scene.buffer.height);
    const auto reach = static_cast<std::size_t>(std::max(1.0, std::round(kReachAt1000 * size / 1000)));
    for (const bool down : {false, true}) blur_along(scene, down, reach, planes);
}

}  // namespace slim
