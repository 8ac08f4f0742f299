#pragma once

#include "slim/base/vec.h"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace slim {

/// Axis-aligned box; empty() until the first extend.
struct Bbox {
    Vec3d lo{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
             std::numeric_limits<double>::infinity()};
    Vec3d hi{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
             -std::numeric_limits<double>::infinity()};

    bool empty() const { return !(lo.x <= hi.x); }
    Vec3d extent() const { return empty() ? Vec3d{} : hi - lo; }
    Vec3d center() const { return empty() ? Vec3d{} : lo + (hi - lo) * 0.5; }
    double diagonal() const { return length(extent()); }

    void extend(const Vec3d& p) {
        lo = {std::min(lo.x, p.x), std::min(lo.y, p.y), std::min(lo.z, p.z)};
        hi = {std::max(hi.x, p.x), std::max(hi.y, p.y), std::max(hi.z, p.z)};
    }
    void extend(const Bbox& b) {
        if (b.empty()) return;
        extend(b.lo);
        extend(b.hi);
    }
    /// Squared distance of a point, 0 inside.
    double sq_distance(const Vec3d& p) const {
        double sq = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double gap = std::max({lo[axis] - p[axis], p[axis] - hi[axis], 0.0});
            sq += gap * gap;
        }
        return sq;
    }
    int longest_axis() const {
        const Vec3d e = extent();
        return e.x >= e.y && e.x >= e.z ? 0 : e.y >= e.z ? 1 : 2;
    }
};

}  // namespace slim
