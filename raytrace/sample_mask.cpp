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

bool SampleMask::any_sample(const PixelWindow& s) const {
    const auto up = [](int n) { return (n + kSide - 1) / kSide; };
    const int x = s.x / kSide, y = s.y / kSide;
    return bounds_in({x, y, up(s.x + s.width) - x, up(s.y + s.height) - y}).width > 0;
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
        const auto row = wanted_.begin() + static_cast<std::ptrdiff_t>(y - part_.y) * part_.width +
                         (on.x - part_.x);
        const auto end = row + on.width, first = std::find(row, end, 1);
        if (first == end) continue;
        const auto last = std::find(std::make_reverse_iterator(end),
                                    std::make_reverse_iterator(first), 1);
        x0 = std::min(x0, on.x + static_cast<int>(first - row));
        x1 = std::max(x1, on.x + static_cast<int>(last.base() - row));
        y0 = std::min(y0, y), y1 = y + 1;
    }
    if (x0 >= x1) return {};
    return {x0, y0, x1 - x0, y1 - y0};
}

}  // namespace slim
