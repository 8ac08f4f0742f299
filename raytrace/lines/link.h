#pragma once

#include "raytrace/lines/crossings.h"
#include "raytrace/lines/feature_line.h"

#include <vector>

namespace slim {

/// Links the crossings on the four edges of every cell of pixel centres, as marching squares does,
/// and follows them: two of a cell belong together; of three or four the pairs that lie closest.
/// Crossings seen on different sheets are not linked. Lengths and strengths are not filled in. Each
/// crossing is a point of at most one line; lines come in the order of their first crossings. cost
/// O(pixels); the cells in parallel; the same for any number of threads
std::vector<FeatureLine> link_crossings(const LineScene& scene, const CrossingField& field,
                                        LineKind kind);

}  // namespace slim
