#include "slim/tree/hull_directions.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace slim {

HullDirections HullDirections::all() {
    constexpr int kHalf = 4;
    HullDirections out;
    std::size_t n = 0;
    for (int i = -kHalf; i <= kHalf; ++i)
        for (int j = -kHalf; j <= kHalf; ++j)
            for (int k = -kHalf; k <= kHalf; ++k) {
                if (std::max({std::abs(i), std::abs(j), std::abs(k)}) < kHalf) continue;
                const double inv = 1 / std::hypot(i, j, k);
                out.x_[n] = i * inv, out.y_[n] = j * inv, out.z_[n] = k * inv;
                out.reach_[n] = -INFINITY, out.id_[n] = static_cast<std::uint32_t>(n);
                ++n;
            }
    out.n_ = n;
    return out;
}

}  // namespace slim
