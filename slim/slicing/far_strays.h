#pragma once

#include "slim/base/bbox.h"
#include "slim/base/vec.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace slim {

/// Finds the few points (a dropped return at the origin, say) that lie so far from all others that
/// the box of a cloud would say nothing of its size, which T is a share of. Keeps the outermost
/// points of each side. Cost: six comparisons a point, more for points that come by rising
/// coordinates; 10 kB.
class FarStrays {
public:
    FarStrays() { innermost_.fill(-std::numeric_limits<double>::infinity()); }
    void add(const Vec3d& p) {
        bool is_outside = false;
        for (std::size_t s = 0; s < sides_.size(); ++s)
            is_outside |= outwards(s, p) > innermost_[s];
        if (is_outside) keep(p);
    }

    struct Found {
        Bbox box;           ///< of the points that are none
        std::size_t n = 0;  ///< strays
        Vec3d example;
    };
    /// Of n points seen. Strays are at most eight a side, and one point in a thousand; they lie
    /// farther beyond the others than half of these' diagonal, and the box with them is at least
    /// twice as large. None: n = 0.
    Found find(std::uint64_t n_points) const;

private:
    static constexpr std::size_t kKept = 56;        ///< outermost points of a side
    /// strays; those of all sides are fewer than kKept
    static constexpr std::size_t kMostOfSide = 8;
    static_assert(6 * kMostOfSide < kKept);

    static double outwards(std::size_t side, const Vec3d& p) {
        return side % 2 ? p[side / 2] : -p[side / 2];
    }
    /// p lies farther out on a side than one of the kept, or these are not yet all.
    void keep(const Vec3d& p);
    /// Coordinate along its axis of the outermost point but `skipped`.
    double limit(std::size_t side, std::size_t skipped) const;

    std::array<std::vector<Vec3d>, 6> sides_;  ///< heaps: the innermost of the kept ones first
    std::array<double, 6>
        innermost_;  ///< that of each, outwards; -infinity until all kKept are there
};

}  // namespace slim
