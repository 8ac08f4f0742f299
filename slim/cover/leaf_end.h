#pragma once

#include "slim/cover/covering_surfel.h"

namespace slim {

/// The share of its radius with which a smooth leaf, whose covered points end in its ball, is drawn
/// hardly farther than they reach (notes/0018): rims are straight and stand at a few reaches only,
/// and what has none is drawn to kHitTrim. 1 where the points do not surely end or are few, or no
/// more is drawn beyond them already; kGoldenRatio where no larger share helps.
/// Cost: as rims_of, and a pass over the points.
double share_at_end(const CoveringSurfel& leaf);

}  // namespace slim
