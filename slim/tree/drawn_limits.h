#pragma once

#include "slim/base/bbox.h"
#include "slim/model/surfel_tree.h"

namespace slim {

/// Where what is drawn of a model's leaves (without `loose`, of those that are not) ends for
/// cameras: the box of the points, whose sides move out to where discs end that reach beyond them
/// by a visible share: 2 % of what a view along the longest axis shows of the model, as much as a
/// picture's margin. Of scans next to none does; of clouds of some ten points discs do by as much as
/// all points take.
/// cost  O(leaves), and the places (append_places) of those that may reach so far, in parallel
Bbox drawn_limits(const SurfelTree& tree, bool loose);

}  // namespace slim
