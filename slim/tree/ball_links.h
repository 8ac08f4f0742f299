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

/// The parent of each ball, an internal one of a coarser level, or kNoNode: the root. Of the finest
/// coarser level on which some ball holds it: the nearest there. n_orphans: those that no ball of
/// the next coarser level with internal surfels holds.
/// cost  a nearest neighbour for each ball, and for each orphan one on every level up to its parent
struct BallLinks {
    std::vector<std::uint32_t> parent;
    std::uint64_t n_orphans = 0;
};
BallLinks link_balls(std::span<const LinkedBall> balls);

}  // namespace slim
