#pragma once

#include "slim/neighbors/point_tree.h"

#include <cstdint>
#include <vector>

namespace slim {

/// A point's random priority: thinnings keep the lowest.
std::uint64_t priority_of(std::uint64_t seed, std::uint64_t id);

/// Whether a point is of the random share of a cloud that its thinnings begin with, by the seed and
/// its id: of a share g^(2 t) it is if it survives the t-th.
bool in_share(std::uint64_t seed, std::uint64_t id, double share);

/// All points of a block and nested random thinnings of them, each keeping g^2 = 0.38 of the one
/// before: a ball grown by 1/g holds as many points of the next thinning as before, so a rung of
/// the radius ladder costs the same whatever its radius (DESIGN 4, "Speed"). Which points survive
/// depends on the seed and the point's id alone.
class PointPyramid {
public:
    /// share: the block holds the points in_share() of a larger cloud, and the pyramid continues
    /// with the cloud's own thinnings below that share.
    PointPyramid(const PointBlock& block, const Bbox& box, std::uint64_t seed, double share = 1);

    std::size_t n_levels() const { return levels_.size(); }
    /// Level 0 holds every point.
    const PointTree& level(std::size_t i) const { return levels_[i]; }
    const PointTree& all() const { return levels_.front(); }

    /// Share of the larger cloud's points in a level.
    double share(std::size_t i) const { return shares_[i]; }
    /// Points of the block by rising random priority; a prefix is a thinning.
    const std::vector<std::uint32_t>& by_priority() const { return by_priority_; }
    /// How many of by_priority() belong to a level.
    std::size_t level_size(std::size_t i) const { return levels_[i].size(); }

private:
    std::vector<PointTree> levels_;
    std::vector<double> shares_;
    std::vector<std::uint32_t> by_priority_;
};

}  // namespace slim
