#pragma once

#include "formats/face_sizes.h"

#include <span>
#include <vector>

namespace slim {

/// The edges about a region with fewer of them: those of a chain are one where it is straight to
/// 0.15 of their sizes and these are alike; the least of them is its size. A disc's rim of 8,000
/// edges is one of some 60. The same for the same edges in the same order.
/// cost  O(n log n)
std::vector<SizedEdge> joined_edges(std::span<const SizedEdge> edges);

}  // namespace slim
