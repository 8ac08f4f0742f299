#include "slim/edges/corners.h"

#include "slim/edges/edge_leaf.h"
#include "slim/model/sharp_edge.h"

#include <algorithm>
#include <optional>

namespace slim {

Corners::Corners(const BallIndex& leaves) {
    for (std::size_t i = 0; i < leaves.n_leaves(); ++i) {
        const Surfel& s = leaves.leaf(i);
        const auto x = s.n_sheets() > 2 ? corner_of(s) : std::nullopt;
        of_leaf_.push_back(x && sq_length(*x) < 1 ? find_or_add(leaves, s, *x) : kNoCorner);
    }
}

std::uint32_t Corners::find_or_add(const BallIndex& leaves, const Surfel& s, const Vec3d& x) {
    constexpr double kSame = 0.15;
    const Vec3d p = s.center + x * s.support_radius;
    leaves.supporters(p, near_);
    for (const Surfel* other : near_) {
        const std::size_t leaf = leaves.number_of(other);
        if (leaf >= of_leaf_.size() || of_leaf_[leaf] == kNoCorner) continue;
        const Corner& corner = found_[of_leaf_[leaf]];
        const double reach = kSame * std::min(corner.radius, s.support_radius);
        if (sq_length(corner.point - p) < reach * reach) return of_leaf_[leaf];
    }
    found_.push_back({p, s.support_radius});
    return static_cast<std::uint32_t>(found_.size() - 1);
}

}  // namespace slim
