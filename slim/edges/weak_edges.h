#pragma once

#include "slim/model/sharp_edge.h"
#include "slim/model/surfel_tree.h"

#include <vector>

namespace slim {

/// How rough a model's sharp leaves are: the median of eps over rho of those that are drawn; 0
/// without any.
double sharp_roughness(const SurfelTree& tree, bool loose);

/// Leaves out the edges that noise makes (notes/0003): those that one leaf alone shows and at which
/// the normal turns, on the mean, by less than 12 `roughness` radians and 45 degrees. What two
/// leaves show, or turns by more, stays, however short. The order stays too.
std::vector<SharpEdge> without_weak_edges(std::vector<SharpEdge> edges, double roughness);

}  // namespace slim
