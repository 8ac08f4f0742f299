#pragma once

#include "slim/smooth/wide_radius.h"

#include <span>
#include <vector>

namespace slim {

/// The surface of a model fitted anew to a cloud for the least error of position (notes/0003): quadratics at places
/// a core apart (kCore), each to all points within the radius that wide_radii gives the leaf there, and the leaves
/// that are kept. In parallel, the same for any thread count.
/// radii  of each leaf, by wide_radii
std::vector<Surfel> refit(const BallIndex& model, std::span<const LeafNoise> noise,
                          std::span<const double> radii, const PointPyramid& points);

}  // namespace slim
