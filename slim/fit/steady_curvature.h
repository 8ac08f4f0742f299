#pragma once

#include "slim/fit/local_fit.h"
#include "slim/neighbors/point_pyramid.h"

namespace slim {

/// The ball that steady_curvature is asked about and what was fitted to it.
struct NarrowFit {
    Vec3d center;
    Frame<double> frame;
    const BallPoints<double>& ball;  ///< contrary points set aside
    LocalFit fit;                    ///< to all of the ball, in `frame`
};

/// A fit whose ball is smaller than its curvature asks for: the ladder ended early (a fold, an
/// edge, too few points), not the energy. Noise s gives curvature an error of about 10 s / (rho^2
/// sqrt(n_eff)): on such balls of raw scans more than the curvature itself, and every leaf gets its
/// own, a speckled map.
///
/// The coefficients of second and third order are therefore taken from balls g^-2 and g^-1 times as
/// wide and from this one, coarse to fine, as far as each difference stands out of its noise (James
/// and Stein
/// 1961, positive part, with two standard errors for one as in DESIGN 4, lesson 3):
///     q_j = q_{j+1} + max(0, 1 - 4 S_j / |a_j - q_{j+1}|^2) (a_j - q_{j+1})
/// S_j: variance of a_j with noise min(eps^2, lambda); norms are those of the homogeneous part,
/// which do not change when the frame turns. What is of first order and below is fitted again to
/// this ball alone, so the surface stays where its points are. Exact and noiseless data are left as
/// they are. degree: asked for the surfel, 2 or 3. `narrow.fit` is returned where no wider ball has
/// the degree, where the result leaves the ball, and where it is a plane whose eps^2 the lent
/// curvature would raise by half. Cost: a gather of about 512 points, two passes over them and one
/// over the narrow ball.
LocalFit steady_curvature(const PointPyramid& points, const NarrowFit& narrow, int degree,
                          double noise_variance, BallPoints<float>& work);

}  // namespace slim
