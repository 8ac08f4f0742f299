#pragma once

#include "slim/base/bbox.h"
#include "slim/model/surfel_tree.h"

#include <vector>

namespace slim {

/// What is drawn of a model beyond the box that its header knows (drawn_bounds), which ends where
/// its points do: of leaves whose discs reach beyond it by a visible share, 2 % of what a view
/// along its longest axis shows of it, as much as a picture's margin. Of scans next to none does;
/// of clouds of some ten points discs do by as much as all points take.
struct BeyondBox {
    Bbox box;  ///< with the sides moved out that discs cross
    /// On all of these leaves (append_close_places); none: the same box.
    std::vector<Vec3d> places;
};

/// cost  O(leaves), and 384 places of each leaf that may reach so far; reads every record
BeyondBox drawn_beyond(const SurfelTree& tree, bool loose, const Bbox& drawn);

}  // namespace slim
