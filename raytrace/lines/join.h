#pragma once

#include "raytrace/lines/feature_line.h"

#include <vector>

namespace slim {

/// Joins lines whose ends meet: 6 px apart or less, on one surface, and going on without a sharp
/// turn (1.5 px apart, round corners too); the nearest and straightest first. Lines that meet
/// themselves are closed. Lengths and strengths are not filled in.
///
/// px        a pixel of a picture 1000 high, in pixels; 1 at least
/// short_px  what is shorter, in pixels, tells no direction to rely on: it is joined round corners
///           over 3 px
/// cost      O(points + ends log ends)
std::vector<FeatureLine> join_ends(std::vector<FeatureLine> lines, float px, float short_px = 0);

}  // namespace slim
