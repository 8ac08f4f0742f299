#pragma once

#include "raytrace/lines/feature_line.h"
#include "raytrace/lines/line_scene.h"

#include <vector>

namespace slim {

/// The visible parts of the scene's sharp edges, convex or concave ones, in the order of the edges.
///
/// Edges are cut to steps of at most a pixel along their cubics. A step is seen where a pixel about it shows
/// one of the edge's faces: its tangent plane within 2 footprints, its normal within 60 degrees of the
/// face's. Kept are edges that turn by 30 degrees or more on the mean and are long enough in this view, all
/// of them counted, hidden parts too; weaker and shorter ones at the corners of kept ones (hysteresis).
///
/// Evidence of a point is the angle by which the normal turns across the edge there, degrees; strength of a
/// line is its mean over the length. Weight is 1 / L. cost     O(points of edges + pixels along them),
/// parallel; the same for any number of threads
std::vector<FeatureLine> visible_creases(const LineScene& scene, LineKind kind);

}  // namespace slim
