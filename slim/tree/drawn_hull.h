#pragma once

#include "slim/base/bbox.h"
#include "slim/model/surfel_tree.h"

#include <cstdint>
#include <vector>

namespace slim {

/// Places on what pictures show of a model's leaves (of loose ones: of those alone), whose convex
/// hull is about that of all of it: in each of 386 directions the farthest of places on the leaves'
/// cores, without what is beyond `box`; along its axes moved onto its faces (not of loose ones). A
/// place is in the list once. Of a ball the hull lacks at most 1.6 % of the radius. `n_tests` gets
/// how many times a leaf, a block of leaves or a place was held against a direction.
///
/// cost  O(leaves), a tenth of a microsecond each and 1 to 2 for those that may reach farthest
///       somewhere, in parallel (notes/0008); the same for any number of threads
std::vector<Vec3d> drawn_hull(const SurfelTree& tree, bool loose, const Bbox& box,
                              std::uint64_t* n_tests = nullptr);

}  // namespace slim
