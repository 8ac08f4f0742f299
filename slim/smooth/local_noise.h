#pragma once

#include "slim/fit/coordinate_steps.h"
#include "slim/neighbors/point_pyramid.h"
#include "slim/smooth/wide_radius.h"
#include "slim/tree/ball_index.h"

#include <cmath>
#include <span>
#include <vector>

namespace slim {

/// Squared noise of a point about each leaf, of which the surface's own shape is no part
/// (disc_noise): the median of the leaves around. That of the fit where a leaf is fitted anew and
/// its residual agrees. Leaves of fewer than 300 points may be all edge: no more than 4 times what
/// the quietest fifth of the 2000 leaves about has (notes/0005), unless their normals agree that it
/// is noise. No less than what the steps of the coordinates make (notes/0006).
/// Infinite: unknown, the cloud does not hold the leaf's points or too few for a disc. In parallel,
/// the same for any thread count.
std::vector<double> local_noise(const BallIndex& model, std::span<const LeafNoise> noise,
                                std::span<const WideRadius> radii, const PointPyramid& points,
                                const CoordinateSteps& steps);

/// The share of the way to the surface that a point goes where it is off by noise and the surface
/// by a bias: 1 as long as the bias is the smaller, sq_noise / sq_bias beyond, so that the point
/// ends no farther off than it was.
double trusted_share(double sq_bias, double sq_noise);

/// What a leaf says of the points about it.
struct LeafTrust {
    float share = 1;  ///< of the way to the surface that they go
    float sq_noise =
        INFINITY;  ///< of them; infinite: unknown, or they go however far the surface is
};

/// Of each leaf of a model, for points that are put on `surface`: that of the model, or its fits.
/// trusted_share() of how far the leaf's points go there, less their noise. All the way where the
/// noise is unknown, and where a leaf is fitted anew and its residual is noise.
std::vector<LeafTrust> leaf_trust(const BallIndex& model, std::span<const WideRadius> radii,
                                  std::span<const double> sq_noise, const BallIndex& surface,
                                  const PointPyramid& points);

/// The share of the way that a point goes which the surface is `distance` from: of leaves, a mean
/// by weight, each less beyond four of its noise: so far off is no noise.
class PointTrust {
public:
    explicit PointTrust(double distance) : sq_distance_(distance * distance) {}
    void add(const LeafTrust& leaf, double weight);
    /// All the way without any leaf.
    double share() const { return weight_ > 0 ? sum_ / weight_ : 1; }

private:
    double sq_distance_, sum_ = 0, weight_ = 0;
};

}  // namespace slim
