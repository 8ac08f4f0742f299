#include "raytrace/lines/sheet_blur.h"

#include "slim/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace slim {
namespace {

constexpr double kReachAt1000 = 3;

/// Calls body(begin, end) for rows of the parts of the planes that lie `margin` entries from either
/// end.
template <class Body>
void for_rows(std::size_t n, std::size_t width, std::size_t margin, const Body& body) {
    parallel_blocks(n, width, [&](std::size_t begin, std::size_t end) {
        begin = std::max(begin, margin), end = std::min(end, n > margin ? n - margin : 0);
        if (begin < end) body(begin, end);
    });
}

SheetWindows windows(const LineScene& s, bool down, std::size_t reach) {
    const auto width = static_cast<std::size_t>(s.buffer.width);
    const std::size_t n = s.buffer.n_pixels();
    SheetWindows w{width, down ? width : 1, reach, std::vector<std::uint8_t>(n, 0),
              std::vector<std::uint8_t>(n, 0)};
    parallel_blocks(n, width, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            if (down ? i + width < n : i + 1 < end) w.joined[i] = one_sheet(s, i, i + w.stride);
    });
    for_rows(n, width, reach * w.stride, [&](std::size_t begin, std::size_t end) {
        std::fill(w.whole.data() + begin, w.whole.data() + end, std::uint8_t{1});
        for (std::size_t k = 0; k < 2 * reach; ++k) {
            const std::uint8_t* from = w.joined.data() + begin + k * w.stride - reach * w.stride;
            std::uint8_t* to = w.whole.data() + begin;
            for (std::size_t i = 0; i < end - begin; ++i)
                to[i] = static_cast<std::uint8_t>(to[i] & from[i]);
        }
    });
    return w;
}

/// The mean over what there is of a window that the sheet's end cuts.
float mean_of_part(const std::vector<float>& plane, const SheetWindows& w, std::size_t i) {
    float sum = plane[i], count = 1;
    const auto add = [&](std::size_t j) { sum += plane[j], ++count; };
    std::size_t j = i;
    for (std::size_t k = 0; k < w.reach && w.joined[j]; ++k) add(j += w.stride);
    j = i;
    for (std::size_t k = 0; k < w.reach && j >= w.stride && w.joined[j - w.stride]; ++k)
        add(j -= w.stride);
    return sum / count;
}

/// Row by row: whole windows as plain sums of shifted rows, then the others one by one. `out` is written all over.
void blur_along(const std::vector<float>& plane, const SheetWindows& w, std::vector<float>& out) {
    const std::size_t n = plane.size(), margin = w.reach * w.stride;
    const float share = 1 / static_cast<float>(2 * w.reach + 1);
    parallel_blocks(n, w.width, [&](std::size_t row, std::size_t row_end) {
        const std::size_t begin = std::max(row, margin), end = std::min(row_end, n > margin ? n - margin : 0);
        if (begin < end) {
            float* to = out.data() + begin;
            std::fill(to, to + (end - begin), 0.0f);
            for (std::size_t k = 0; k <= 2 * w.reach; ++k) {
                const float* from = plane.data() + begin + k * w.stride - margin;
                for (std::size_t i = 0; i < end - begin; ++i) to[i] += share * from[i];
            }
        }
        for (std::size_t i = row; i < row_end; ++i)
            if (!w.whole[i]) out[i] = mean_of_part(plane, w, i);
    });
}

}  // namespace

SheetBlur::SheetBlur(const LineScene& scene) {
    const double size = std::min(scene.buffer.width, scene.buffer.height);
    const auto reach =
        static_cast<std::size_t>(std::max(1.0, std::round(kReachAt1000 * size / 1000)));
    for (const bool down : {false, true}) along_[down] = windows(scene, down, reach);
}

void SheetBlur::operator()(std::span<std::vector<float>> planes) const {
    std::vector<float> blurred(along_[0].joined.size());
    for (std::vector<float>& plane : planes)
        for (const SheetWindows& w : along_) {
            blur_along(plane, w, blurred);
            plane.swap(blurred);
        }
}

}  // namespace slim
