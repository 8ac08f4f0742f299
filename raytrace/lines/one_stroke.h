#pragma once

#include "raytrace/lines/feature_line.h"

#include <vector>

namespace slim {

/// Leaves one stroke to each edge of the lines of a picture, where kinds found by themselves run
/// beside each other: within 2.5 pixels of a picture 1000 high, within 30 degrees of parallel, for
/// 6 such pixels or more.
///
/// - Where a contour and a crease are one place of the surface, the crease is drawn, which is the
///   truer: as a contour if a face is turned away there, so that the outline goes on, and as the
///   crease it is if both are seen, where nothing ends but a leaf.
/// - Elsewhere creases go, what they edge ends in nearly the same line of sight; crest lines and
///   suggestive contours go along all contours.
///
/// What leaves the other line stays, and begins at a point of it. Where no contours are among the
/// lines all stay as they are, in their order.
///
/// lines   as LineSearch finds them; facing of a crease's points: see
///         feature_line.h
/// px      a pixel of a picture 1000 high, in pixels; 1 at least
/// cost    O(points), while lines do not crowd, and O(n log n) of contours cut
std::vector<FeatureLine> one_stroke(std::vector<FeatureLine> lines, float px);

}  // namespace slim
