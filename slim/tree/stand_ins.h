#pragma once

#include "slim/model/surfel_tree.h"

#include <cstdint>

namespace slim {

/// Marks internal surfels that may stand in for all below them where these would be finer than the
/// picture (kStandsIn): with at least eight children, a fit to 1/32 of the radius, and a surface
/// that leaves agree with all over the ball: each of 19 places on it (its centre, six half a radius
/// about it, twelve at 0.95) lies within kBelongs of the radius of a leaf's surface, in that leaf's
/// ball, with normals less than 20 degrees apart. So none sticks out beyond an edge or a border.
/// Leaves that are sharp, loose or end at a rim agree with nothing. Returns how many are marked.
///
/// cost  19 walks down the tree for each internal surfel of many children, in parallel:
///       1 to 2 us each
std::uint64_t mark_stand_ins(SurfelTreeData& tree);

}  // namespace slim
