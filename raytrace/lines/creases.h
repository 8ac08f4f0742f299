#pragma once

#include "raytrace/lines/feature_line.h"
#include "raytrace/lines/line_scene.h"

#include <cstdint>
#include <vector>

namespace slim {

/// The search for the visible parts of a scene's sharp edges, convex or concave ones, in the order
/// of the edges; the picture may be seen band by band as in LineSearch.
///
/// Edges are cut to steps of at most a pixel along their cubics. A step is seen where a pixel about
/// it shows one of the edge's faces: its tangent plane within 2 footprints, its normal within 60
/// degrees of the face's. Kept are edges that turn by 30 degrees or more on the mean and are long
/// enough in this view, all of them counted, hidden parts too; weaker and shorter ones at the
/// corners of kept ones (hysteresis).
///
/// Evidence of a point is the angle by which the normal turns across the edge there, degrees;
/// strength of a line is its mean over the length in the picture.
///
/// cost     O(points of edges + pixels along them) a band, parallel; the same for any number of
///          threads and bands
class CreaseSearch {
public:
    explicit CreaseSearch(LineKind kind) : kind_(kind) {}

    /// The steps in the rows of a band; bands follow each other from the top down.
    void add(const LineScene& scene);
    /// Once all rows were added.
    const std::vector<FeatureLine>& lines() const { return lines_; }

private:
    LineKind kind_;
    std::vector<std::vector<std::uint8_t>> is_seen_;  ///< of each edge's steps
    std::vector<FeatureLine> lines_;
};

}  // namespace slim
