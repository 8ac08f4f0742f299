#pragma once

#include "slim/base/vec.h"

namespace slim {

/// The neighbours of a point on the two sides of a seam, where normals turn round (notes/0006):
/// those that agree with it and those that do not.
template <class T>
class SeamSides {
public:
    /// d: from the point
    void add(const Vec3<T>& d, bool agrees) {
        sum_[agrees] += d;
        count_[agrees] += 1;
    }
    bool have(T fewest) const { return count_[0] >= fewest && count_[1] >= fewest; }
    /// Whether the sides lie beside each other: their means 0.6 of the reach apart, of half discs
    /// 0.85. The sides of a thin sheet or of a crease do nowhere. Both have neighbours.
    bool lie_apart(T sq_reach) const {
        constexpr T kApart = T(0.6);
        const Vec3<T> apart = sum_[1] / count_[1] - sum_[0] / count_[0];
        return sq_length(apart) > kApart * kApart * sq_reach;
    }

private:
    Vec3<T> sum_[2];
    T count_[2] = {0, 0};
};

}  // namespace slim
