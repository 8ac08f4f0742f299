#pragma once

#include "slim/base/vec.h"
#include "slim/model/surfel_encoder.h"

#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// What linking wants to know of a surfel: a sixth of it.
struct LinkedBall {
    Vec3d center;
    double support_radius;
    std::uint8_t level, flags, degree, n_extra;

    SurfelShape shape() const { return {center, degree, n_extra}; }
};

struct BallLinks {
    std::vector<std::uint32_t> parent;  ///< kNoNode: the root
    std::uint64_t n_orphans = 0;  ///< that no ball of the next level with internal ones holds
};

/// The parent of each ball: the nearest internal one of the finest of the coarser levels where that
/// holds it: its core reaches no farther from the middle than that of a ball of the next level
/// whose centre lies within. So what is below a ball lies within 2.7 of its radii (notes/0009).
/// cost  a nearest neighbour for each ball, and for each orphan one on every level up to its
///       parent; an index of one level at a time
BallLinks link_balls(std::span<const LinkedBall> balls);

}  // namespace slim
