#pragma once

#include "raytrace/lines/feature_line.h"

#include <vector>

namespace slim {

/// Makes one line of what the search for contours has cut or doubled,
/// before short ones are dropped:
///
/// - parts whose evidence says that the surface does not end there,
///   ends of a line or longer than a few pixels, go;
/// - what runs beside a longer line, within 1.9 pixels, is left to that line;
/// - ends that meet are joined (join_ends).
///
/// px      a pixel of a picture 1000 high, in pixels; 1 at least
/// cost    O(points), and O(ends log ends)
std::vector<FeatureLine> tidy_contours(std::vector<FeatureLine> lines, float px);

}  // namespace slim
