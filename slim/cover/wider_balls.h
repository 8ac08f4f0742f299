#pragma once

#include "slim/cover/surfel_fit.h"
#include "slim/fit/ball_points.h"
#include "slim/model/rim.h"
#include "slim/neighbors/point_tree.h"

#include <cstddef>
#include <vector>

namespace slim {

/// Radii above `least`, falling, up to `most`: those whose balls hold n_wanted points and, in four
/// steps of the same ratio, fewer, down towards what the least one holds. None where that holds as
/// many. `ball` is left one about the centre that holds those of all of them.
/// Cost: gathers of some 1.5 n_wanted points on a surface.
std::vector<float> wider_radii(const PointTree& points, const Vec3d& center, double least,
                               double most, std::size_t n_wanted, BallPoints<double>& ball);

/// Of a ball's points, less those that face away from a unit normal, the share that faces neither
/// its way nor the other: much of it beyond an edge, little of a plate's two sides.
double share_sideways(const BallPoints<double>& ball, const Vec3d& normal);

/// Whether the leaf of such a ball is fitted well, eps < 0.06 rho: known before its points are
/// listed.
bool is_thin_enough(const CoveringSurfel& leaf);

/// Whether it explains its centre besides.
bool is_well_fitted(const CoveringSurfel& leaf);

/// Whether the ball of a leaf holds an edge, which sheets would show better: more than four signs
/// of one, or a point of its own.
bool has_edge_signs(const CoveringSurfel& leaf);

/// Whether a leaf's rims lie before all places where it would stand far in the air,
/// CoveringSurfel::air (notes/0012).
bool ends_before_air(const CoveringSurfel& leaf);

}  // namespace slim
