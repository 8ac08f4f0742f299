#pragma once

#include "slim/neighbors/point_pyramid.h"
#include "slim/smooth/refit.h"
#include "slim/smooth/wide_radius.h"
#include "slim/tree/ball_index.h"

#include <span>
#include <vector>

namespace slim {

/// Squared noise of a point about each leaf, from discs so narrow that the surface's own shape is no part of it: a
/// quartic through about 75 points, or a quadratic through about 24, at the leaf's centre, a mean over the leaves
/// around. Where a leaf is fitted anew, its fit's. No more than 3 times the noise (9 squared) that the quietest fifth of
/// the points has: what an edge leaves in a disc is no noise (notes/0004). Infinite: unknown, the cloud does not hold the leaf's points.
/// In parallel, the same for any thread count.
std::vector<double> local_noise(const BallIndex& model, std::span<const LeafNoise> noise,
                                std::span<const WideRadius> radii, const PointPyramid& points);

/// The share of the way to the surface that a point goes where it is off by noise and the surface by a bias: 1 as long
/// as the bias is the smaller, sq_noise / sq_bias beyond, so that the point ends no farther off than it was.
/// sq_displacement  mean over points put on the surface: their noise and the surface's bias
double trusted_share(double sq_displacement, double sq_noise);

/// trusted_share() of each leaf: where it is kept from the points in it, else from its fit's residual. 1 where the
/// noise is unknown.
std::vector<double> trusted_shares(const BallIndex& model, std::span<const WideRadius> radii,
                                   std::span<const double> sq_noise, const RefittedSurface& surface,
                                   const PointPyramid& points);

}  // namespace slim
