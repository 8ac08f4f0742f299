#include "slim/edges/corners.h"

#include "slim/model/sharp_edge.h"

#include <algorithm>
#include <cmath>

namespace slim {

Corners::Corners(const BallIndex& leaves) {
    for (std::size_t i = 0; i < leaves.n_leaves(); ++i) {
        const Surfel& s = leaves.leaf(i);
        if (s.n_sheets() > 2)
            for (const LeafCorner& own : corners_of(s))
                of_leaves_.push_back({find_or_add(leaves, s, own.x), own});
        begin_.push_back(of_leaves_.size());
    }
}

std::uint32_t Corners::nearest(std::size_t leaf, std::size_t pair, const Vec3d& p) const {
    std::uint32_t best = kNoCorner;
    double least = INFINITY;
    for (const OfLeaf& corner : of_leaf(leaf)) {
        if (!corner.own.is_of(kSheetPairs[pair])) continue;
        const double sq = sq_length(found_[corner.number].point - p);
        if (sq < least) least = sq, best = corner.number;
    }
    return best;
}

std::uint32_t Corners::find_or_add(const BallIndex& leaves, const Surfel& s, const Vec3d& x) {
    constexpr double kSame = 0.15;
    const Vec3d p = s.center + x * s.support_radius;
    leaves.supporters(p, near_);
    for (const Surfel* other : near_) {
        const std::size_t leaf = leaves.number_of(other);
        if (leaf + 1 >= begin_.size()) continue;  // not asked yet
        for (const OfLeaf& known : of_leaf(leaf)) {
            const Corner& corner = found_[known.number];
            const double reach = kSame * std::min(corner.radius, s.support_radius);
            if (sq_length(corner.point - p) < reach * reach) return known.number;
        }
    }
    found_.push_back({p, s.support_radius});
    return static_cast<std::uint32_t>(found_.size() - 1);
}

}  // namespace slim
