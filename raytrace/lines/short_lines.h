#pragma once

#include "raytrace/lines/feature_line.h"
#include "raytrace/lines/select.h"

#include <vector>

namespace slim {

/// Makes of the short lines that select_lines keeps, as they continue others, parts of these:
///
/// - ends that meet are joined (join_ends);
/// - what is shorter than rules.least_px then is dropped, but for closed lines, and of contours
///   (rules.meets_anywhere) for bridges: their ends meet longer lines at places that lie apart, two
///   lines' or one's that comes back. Beside one line a short one shows nothing;
/// - of contours, small loops less than 1.2 px wide on the mean are dropped.
///
/// px      a pixel of a picture 1000 high, in pixels; 1 at least
/// cost    O(points, and ends log ends)
std::vector<FeatureLine> link_short_lines(std::vector<FeatureLine> lines, const LineRules& rules,
                                          float px);

}  // namespace slim
