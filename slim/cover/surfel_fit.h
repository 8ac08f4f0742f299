#pragma once

#include "slim/cover/covering_surfel.h"
#include "slim/cover/surfel_points.h"
#include "slim/fit/local_fit.h"
#include "slim/fit/radius_ladder.h"
#include "slim/fit/sharp_search.h"
#include "slim/fit/steady_curvature.h"
#include "slim/model/fitted_surfel.h"
#include "slim/neighbors/point_pyramid.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace slim {

/// Whether the points that a surfel covers are listed at once, or only measured: list_points adds
/// them. Many a leaf is given up by its measures, and the lists take as long as the fit.
enum class Lists : std::uint8_t { made, left_out };

/// The exact fit at a chosen radius: all points of the ball, in doubles, frame of the rounded
/// normal. With `forced` (the radius was not chosen by E, the points are few) the surfel takes the
/// lowest degree that explains them within the noise, eps <= 2 sqrt(lambda): a higher one would fit
/// the noise and speckle a curvature map. Any other takes the degree if it has 2 K points
/// (notes/0009); where edges are looked for and the ball holds one, if they leave enough freedom:
/// few points beside an edge would bend it.
CoveringSurfel fit_surfel(const PointTree& points, const Vec3d& center, const Vec3d& normal,
                          double radius, int degree, bool forced, double noise_variance,
                          BallPoints<double>& work, Edges edges = Edges::ignored,
                          Lists lists = Lists::made);

/// The same of the points in a ball about the centre that was gathered already.
CoveringSurfel fit_gathered_surfel(const PointTree& points, const Vec3d& center,
                                   const Vec3d& normal, int degree, bool forced,
                                   double noise_variance, BallPoints<double>& ball, Edges edges,
                                   Lists lists = Lists::made);

/// Workspace of fit_steady_surfel.
struct SteadyWork {
    BallPoints<double> ball;
    BallPoints<float> wider;
};

/// The same for a leaf whose radius the energy did not choose (forced, or limited by a fold): its
/// curvature is steadied by wider balls (slim/fit/steady_curvature.h).
CoveringSurfel fit_steady_surfel(const PointPyramid& points, const Vec3d& center,
                                 const Vec3d& normal, double radius, int degree, bool forced,
                                 double noise_variance, SteadyWork& work,
                                 Lists lists = Lists::made);

/// The exact fit of an edge's or a corner's sheets at a chosen radius (SharpSearch), all points of
/// the ball. Nothing if they do not fall into so many sheets as the search's sample did.
std::optional<CoveringSurfel> fit_sharp_surfel(const PointTree& points, const Vec3d& center,
                                               const SharpSearch::Choice& choice, int degree,
                                               double noise_variance, BallPoints<double>& work,
                                               SharpWork<double>& sharp);

/// A surfel made elsewhere and the tree's points that it covers and has beside it, by the same
/// rules; the rest is left as it is by default. Of those that are wanted,
/// or of all if that is empty.
CoveringSurfel cover_again(const PointTree& points, const FittedSurfel& surfel,
                           double noise_variance, BallPoints<double>& work,
                           const WantedOfBucket& wanted = {});

}  // namespace slim
