#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace slim {

/// How many points of a list are a slice's own, not of its surroundings.
inline std::size_t count_own(const std::vector<bool>& own,
                             const std::vector<std::uint32_t>& points) {
    return static_cast<std::size_t>(
        std::count_if(points.begin(), points.end(), [&](std::uint32_t i) { return own[i]; }));
}

/// The same of points that are marked.
inline std::size_t count_own(const std::vector<bool>& own, const std::vector<bool>& marked) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < marked.size(); ++i) n += marked[i] && own[i];
    return n;
}

}  // namespace slim
