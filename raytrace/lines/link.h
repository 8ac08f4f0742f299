#pragma once

#include "raytrace/lines/crossings.h"
#include "raytrace/lines/feature_line.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// The two neighbours of every crossing on its line, -1 for none: first that in the upper or left
/// one of its edge's two cells.
using LineLinks = std::vector<std::array<std::int32_t, 2>>;

/// Links the crossings on the four edges of every cell of pixel centres, as marching squares does:
/// two of a cell belong together; of three or four the pairs that lie closest. Crossings seen on
/// different sheets are not linked. cost O(pixels); the cells in parallel; the same for any number
/// of threads
LineLinks link_cells(const LineScene& scene, const CrossingField& field, LineKind kind);

/// Lines along the links. Lengths and strengths are not filled in. Each crossing is a point of at
/// most one line; lines come in the order of their first crossings.
std::vector<FeatureLine> follow_links(std::span<const LinePoint> crossings, const LineLinks& links,
                                      LineKind kind);

/// Both of a whole picture.
std::vector<FeatureLine> link_crossings(const LineScene& scene, const CrossingField& field,
                                        LineKind kind);

/// A crossing as a point of its line.
LinePoint line_point(const Crossing& c);

}  // namespace slim
