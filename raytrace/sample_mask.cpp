#include "raytrace/sample_mask.h"

#include <algorithm>

namespace slim {
namespace {

/// What two windows share; width 0 if nothing.
PixelWindow shared(const PixelWindow& a, const PixelWindow& b) {
    const int x = std::max(a.x, b.x), y = std::max(a.y, b.y);
    const int width = std::min(a.x + a.width, b.x + b.width) - x,
              height = std::min(a.y + a.height, b.y + b.height) - y;
    if (width <= 0 || height <= 0) return {};
    return {x, y, width, height};
}

}  // namespace

void SampleMask::copy_row(int x, int y, std::span<std::uint8_t> out) const {
    std::fill(out.begin(), out.end(), std::uint8_t{0});
    const PixelWindow on = shared({x, y, static_cast<int>(out.size()), 1}, part_);
    if (on.width > 0) std::copy_n(pixel(on.x, on.y), on.width, out.data() + (on.x - x));
}

bool SampleMask::any_sample(const PixelWindow& s) const {
    const auto up = [](int n) { return (n + kSide - 1) / kSide; };
    const int x = s.x / kSide, y = s.y / kSide;
    const PixelWindow on = shared({x, y, up(s.x + s.width) - x, up(s.y + s.height) - y}, part_);
    for (int row = on.y; row < on.y + on.height; ++row)
        if (any_of_row(on.x, row, on.width)) return true;
    return false;
}

SampleMask SampleMask::grown() const {
    SampleMask out(part_);
    const int w = part_.width, h = part_.height;
    const auto at = [&](int x, int y) {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(w) +
               static_cast<std::size_t>(x);
    };
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
            if (!wanted_[at(x, y)]) continue;
            for (int v = std::max(0, y - 1); v <= std::min(h - 1, y + 1); ++v)
                for (int u = std::max(0, x - 1); u <= std::min(w - 1, x + 1); ++u)
                    out.wanted_[at(u, v)] = 1;
        }
    return out;
}

PixelWindow SampleMask::bounds_in(const PixelWindow& window) const {
    const PixelWindow on = shared(window, part_);
    int x0 = on.x + on.width, x1 = on.x, y0 = on.y + on.height, y1 = on.y;
    for (int y = on.y; y < on.y + on.height; ++y) {
        if (!any_of_row(on.x, y, on.width)) continue;
        const std::uint8_t* const row = pixel(on.x, y);
        int first = 0, last = on.width;
        while (row[first] == 0) ++first;
        while (row[last - 1] == 0) --last;
        x0 = std::min(x0, on.x + first), x1 = std::max(x1, on.x + last);
        y0 = std::min(y0, y), y1 = y + 1;
    }
    if (x0 >= x1) return {};
    return {x0, y0, x1 - x0, y1 - y0};
}

}  // namespace slim
