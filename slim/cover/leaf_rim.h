#pragma once

#include "slim/cover/surfel_fit.h"
#include "slim/model/rim.h"

namespace slim {

/// The rim of a leaf: in the direction in which the points that it covers reach least far, a little more than one
/// spacing of theirs beyond the last of them. 0 where that is more than 0.56 rho, as on most surfaces, and for
/// sharp leaves (notes/0007).
/// Cost: 32 products a point, by lanes.
PackedRim rim_of(const CoveringSurfel& leaf);

}  // namespace slim
