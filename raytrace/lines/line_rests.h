#pragma once

#include "raytrace/lines/feature_line.h"
#include "raytrace/lines/placed_lines.h"

#include <cstdint>
#include <vector>

namespace slim {

/// Which points of a line have placed ones beside them: no run of fewer than 6 pixels of a picture
/// 1000 high, as lines that meet or cross have, but crumbs between and beyond them of up to 8 that
/// others pass. A closed line is turned so that a run of them begins at its first point.
///
/// in_space  beside and at one place in space
/// cost      O(points), while lines do not crowd
std::vector<std::uint8_t> shared_points(FeatureLine& line, const PlacedLines& placed, bool in_space,
                                        float px);

/// Moves an end of a line, its first point or its last, to one of another line, if there is one, in
/// the picture: `in_space`, or `in_picture` where that is null. In space it moves to the former
/// only, and what is before it by less and less, over 20 pixels of a picture 1000 high or to the
/// other end: the points of a limb lie some pixels before or behind the edge that ends it.
void move_end(FeatureLine& line, bool back, const LinePoint* in_space, const LinePoint* in_picture,
              float px);

/// Adds what is left of a line without its shared points: all of it, or rests that begin and end
/// at points of the placed lines. In space they do so only if in_space; otherwise they stay where
/// they are there, as the others may be anywhere before or behind.
///
/// returns   whether less than all is left
bool add_rests(FeatureLine line, const PlacedLines& placed, bool in_space, float px,
               std::vector<FeatureLine>& out);

}  // namespace slim
