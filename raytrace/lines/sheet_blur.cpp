#include "raytrace/lines/sheet_blur.h"

#include "slim/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace slim {
namespace {

constexpr double kReachAt1000 = 3;

/// How far the sheet goes around every pixel in one direction of the grid.
struct Windows {
    std::size_t width = 0, stride = 1, reach = 1;
    std::vector<std::uint8_t> joined;  ///< on one sheet with the next pixel?
    std::vector<std::uint8_t> whole;   ///< with all `reach` pixels to both sides?
};

/// Calls body(begin, end) for rows of the parts of the planes that lie `margin` entries from either
/// end.
template <class Body>
void for_rows(std::size_t n, std::size_t width, std::size_t margin, const Body& body) {
    parallel_blocks(n, width, [&](std::size_t begin, std::size_t end) {
        begin = std::max(begin, margin), end = std::min(end, n > margin ? n - margin : 0);
        if (begin < end) body(begin, end);
    });
}

Windows windows(const LineScene& s, bool down, std::size_t reach) {
    const auto width = static_cast<std::size_t>(s.buffer.width);
    const std::size_t n = s.buffer.n_pixels();
    Windows w{width, down ? width : 1, reach, std::vector<std::uint8_t>(n, 0),
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
float mean_of_part(const std::vector<float>& plane, const Windows& w, std::size_t i) {
    float sum = plane[i], count = 1;
    const auto add = [&](std::size_t j) { sum += plane[j], ++count; };
    std::size_t j = i;
    for (std::size_t k = 0; k < w.reach && w.joined[j]; ++k) add(j += w.stride);
    j = i;
    for (std::size_t k = 0; k < w.reach && j >= w.stride && w.joined[j - w.stride]; ++k)
        add(j -= w.stride);
    return sum / count;
}

/// Whole windows as plain sums of shifted rows, then the others one by one.
std::vector<float> blurred_along(const std::vector<float>& plane, const Windows& w) {
    std::vector<float> out(plane.size(), 0.0f);
    for_rows(plane.size(), w.width, w.reach * w.stride, [&](std::size_t begin, std::size_t end) {
        float* to = out.data() + begin;
        const float share = 1 / static_cast<float>(2 * w.reach + 1);
        for (std::size_t k = 0; k <= 2 * w.reach; ++k) {
            const float* from = plane.data() + begin + k * w.stride - w.reach * w.stride;
            for (std::size_t i = 0; i < end - begin; ++i) to[i] += share * from[i];
        }
    });
    parallel_blocks(plane.size(), w.width, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            if (!w.whole[i]) out[i] = mean_of_part(plane, w, i);
    });
    return out;
}

}  // namespace

void blur_on_sheets(const LineScene& scene, std::span<std::vector<float>> planes) {
    const double size = std::min(scene.buffer.width, scene.buffer.height);
    const auto reach =
        static_cast<std::size_t>(std::max(1.0, std::round(kReachAt1000 * size / 1000)));
    for (const bool down : {false, true}) {
        const Windows w = windows(scene, down, reach);
        for (std::vector<float>& plane : planes) plane = blurred_along(plane, w);
    }
}

}  // namespace slim
