#pragma once

#include <boost/math/tools/minima.hpp>

#include <cmath>
#include <cstdint>

namespace slim {

/// The share, from exp(log_least) to 1, at which value(log(share)) is least, by Brent's method in
/// eight steps at most. In logarithms 2 % are 0.02 anywhere (NUMERICS 3.3).
template <class Value>
double least_share(double log_least, const Value& value) {
    // Keeps the argument away from 0, where the library's tolerance would vanish.
    constexpr double kOffset = 2;
    std::uintmax_t most = 8;
    const auto found = boost::math::tools::brent_find_minima(
        [&](double x) { return value(x - kOffset); }, log_least + kOffset, kOffset, 8, most);
    return std::exp(found.first - kOffset);
}

}  // namespace slim
