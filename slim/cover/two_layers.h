#pragma once

#include "slim/cover/covering_surfel.h"

namespace slim {

/// Whether the points of a smooth leaf lie in two layers, above and below it, as those of two
/// sheets do that it runs between: the fourth moment of their heights is less than 1.5 times the
/// square of the second (1 for two layers, 1.8 if spread evenly, 3 for noise). Not of fewer than 24
/// points. Tells gaps of more than some six times the points' noise. Cost: a pass over them.
bool lies_between_layers(const CoveringSurfel& leaf);

}  // namespace slim
