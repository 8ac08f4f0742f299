#pragma once

#include "slim/base/bbox.h"
#include "slim/base/vec.h"

#include <algorithm>
#include <cstdint>

namespace slim {

/// Spreads the low 21 bits of v to every third bit.
constexpr std::uint64_t spread_bits(std::uint64_t v) {
    v &= 0x1fffff;
    v = (v | v << 32) & 0x1f00000000ffffull;
    v = (v | v << 16) & 0x1f0000ff0000ffull;
    v = (v | v << 8) & 0x100f00f00f00f00full;
    v = (v | v << 4) & 0x10c30c30c30c30c3ull;
    v = (v | v << 2) & 0x1249249249249249ull;
    return v;
}

/// Place of a point on the Morton curve of a cube: 21 bits an axis.
class MortonCurve {
public:
    explicit MortonCurve(const Bbox& box) : lo_(box.lo) {
        const Vec3d e = box.extent();
        const double edge = std::max({e.x, e.y, e.z});
        scale_ = edge > 0 ? 2097151.0 / edge : 0;
    }
    std::uint64_t key(const Vec3d& p) const {
        return spread_bits(cell(p.x - lo_.x)) | spread_bits(cell(p.y - lo_.y)) << 1 |
               spread_bits(cell(p.z - lo_.z)) << 2;
    }

private:
    std::uint64_t cell(double d) const {
        return static_cast<std::uint64_t>(std::clamp(d * scale_, 0.0, 2097151.0));
    }
    Vec3d lo_;
    double scale_;
};

}  // namespace slim
