#pragma once

#include "slim/cover/surfel_fit.h"
#include "slim/model/rim.h"

namespace slim {

/// The rims of a leaf, up to two: where the points that it covers end on one side, a little more
/// than one spacing of theirs beyond the last of them (notes/0007), or at the edge that the ball's
/// other points show (notes/0008); first of all before the places where the leaf stands in the air
/// (notes/0012), but for what covered points forbid. None where those are farther than 0.56 rho, as
/// on most surfaces, and for sharp leaves. Cost: 32 products a point, until no rim is possible any
/// more.
PackedRims rims_of(const CoveringSurfel& leaf);

/// The share of its radius with which a smooth leaf is drawn no farther than the edges that its
/// ball's points show: rims stand at a few reaches only, and what has none is drawn to kHitTrim. 1
/// where none is near or none helps.
double share_at_edges(const CoveringSurfel& leaf);

}  // namespace slim
