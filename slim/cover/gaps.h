#pragma once

#include "slim/model/surfel.h"
#include "slim/neighbors/point_tree.h"

#include <cstdint>
#include <vector>

namespace slim {

/// A gap between leaves: a place just beyond what is drawn of a smooth leaf that no other leaf
/// draws either, though points of the same sheet lie about it on all sides (notes/0021).
struct Gap {
    Vec3d place;          ///< of the points' frame
    Vec3d normal;         ///< unit, of the leaf
    std::uint32_t point;  ///< the nearest of them, in the tree
};

/// The gaps between leaves, by leaf along a curve: a gap has as many places as leaves see of it.
/// leaves: of the points, and of all that is drawn beside them.
/// Cost: O(n log n) lists of n leaves that lie together; for each leaf 32 places times the leaves
/// whose balls meet its own, 4 us in all; for places that nobody draws a search for ten points.
std::vector<Gap> find_gaps(const PointTree& points, const std::vector<const Surfel*>& leaves);

}  // namespace slim
