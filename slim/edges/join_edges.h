#pragma once

#include "slim/model/sharp_edge.h"

#include <array>
#include <vector>

namespace slim {

/// An edge as followed, with the mean radius of the leaves about its ends.
struct TracedEdge {
    SharpEdge edge;
    std::array<double, 2> radius{};
};

/// Joins edges over gaps between leaves: ends at no corner, less than a radius apart, that lead to
/// each other (within 45 degrees of the gap) between the same faces (normals within 37 degrees);
/// the nearest pairs first. The order is that of each one's first part. cost O(n log n) for n edges
/// of like radius
std::vector<SharpEdge> joined_edges(std::vector<TracedEdge> edges);

}  // namespace slim
