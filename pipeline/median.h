#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace slim {

/// Of at least one value; the mean of the middle two of an even number.
inline double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const std::size_t n = values.size();
    return n % 2 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

}  // namespace slim
