#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

namespace slim {

/// From where to where along a bar a tick's number goes.
struct NumberSpan {
    float from, to;
};

/// Which of a bar's ticks have their numbers: each so many, and the last one.
struct NumberChoice {
    std::size_t stride, first;
    std::size_t last, too_near;  ///< from too_near on only the last one has its number
    bool has(std::size_t tick) const {
        return tick == last || (tick < too_near && tick % stride == first);
    }
};

/// The most of them of which none comes nearer to the next than a gap, 0 among them and the end of
/// the range, which takes the place of one too near to it.
///
/// ticks  ascending; spans: of their numbers, in the same order
inline NumberChoice numbers_apart(std::span<const double> ticks, std::span<const NumberSpan> spans,
                                  float gap) {
    const auto at_zero = std::find(ticks.begin(), ticks.end(), 0.0);
    const auto zero = at_zero == ticks.end()
                          ? std::size_t{0}
                          : static_cast<std::size_t>(at_zero - ticks.begin());
    std::size_t stride = 1;
    const auto touches = [&] {
        for (std::size_t i = zero % stride; i + stride < spans.size(); i += stride)
            if (spans[i + stride].from < spans[i].to + gap) return true;
        return false;
    };
    while (stride < ticks.size() && touches()) ++stride;
    const std::size_t n = spans.size(), last = n == 0 ? 0 : n - 1;
    if (n == 0 || (zero != last && spans[zero].to + gap > spans[last].from))
        return {stride, zero % stride, n, n};
    std::size_t too_near = last;
    while (too_near > zero + 1 && spans[too_near - 1].to + gap > spans[last].from) --too_near;
    return {stride, zero % stride, last, too_near};
}

}  // namespace slim
