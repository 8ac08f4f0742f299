#pragma once

#include "slim/model/surfel_tree.h"

#include <cstdint>
#include <vector>

namespace slim {

/// Some nodes of a model, and how many each of them stands for.
struct SampledNodes {
    std::vector<std::uint32_t> nodes;
    std::vector<double> stand_for;
};

/// The nodes that curvature_noise() is to look at, the same for every view: all of models up to
/// 65,536 nodes, else 1,920 in 60 runs, so that few pages of the file are read for them: 0.5 MB. Of
/// a sculpture of 238,542 such samples give what is the middle leaf between 44 and 55 in 100 of the
/// area, evenly spaced ones anything: a third of the area lies in the first tenth of the nodes.
SampledNodes nodes_for_curvature_noise(const SurfelTree& tree);

/// The curvature that a model's fit makes of what it does not know, noise of the points or bias,
/// 1 / length: three times the 95th percentile of the mean curvatures of noisy planes. By the
/// leaves' residuals eps, radii rho and points n, 140 eps / (rho^2 sqrt(n)), as of a fit of their
/// slopes' slopes; the middle one by area (half of the leaves' area has less). 0 without leaves.
///
/// Measured on planes, dishes and plates of 3,000 to 200,000 points with noise of 1e-4 to 5e-4 of
/// the diagonal: the percentile is 34 to 52 eps / (rho^2 sqrt(n)).
///
/// sample  that of nodes_for_curvature_noise(); its nodes must have been checked
/// cost  O(n log n) of the nodes
double curvature_noise(const SurfelTree& tree, const SampledNodes& sample);

}  // namespace slim
