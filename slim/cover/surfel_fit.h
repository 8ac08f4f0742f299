#pragma once

#include "slim/base/unfilled_vector.h"
#include "slim/cover/air_places.h"
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

/// A point that a surfel covers, and by how much.
struct Covered {
    std::uint32_t point;  ///< index in the block
    float weight;         ///< G(|p - c| / rho)
    float u, v;           ///< place in the tangent plane, over rho
    float off;            ///< height above the surface, over rho
    bool in_core;         ///< |p - c| < alpha rho
};

/// Where the surface of a point that a surfel does not explain cuts the surfel's own: a line u x +
/// v y = reach in its tangent plane, coordinates over rho, beyond which the surfel would stand out
/// of that surface.
struct EdgeSign {
    float u, v;  ///< unit
    float reach;
};

/// A point that a surfel covers though its normal stands at 30 degrees or more to the surfel's: an
/// edge's own, whose normal is the mean of its faces' (notes/0011).
struct EdgePoint {
    float u, v;  ///< unit: the way along the tangent plane that its normal leans
    float x, y;  ///< its place there, over rho
};

/// What edges are to a fit: nothing (they are not looked for), something that noise may feign, or
/// real, because the cloud and its normals are clean.
enum class Edges : std::uint8_t { ignored, doubtful, real };

/// A surfel and the points it covers: those it explains, |residual| <= min(4 max(eps, sqrt lambda),
/// 0.3 rho), that do not face away (DESIGN 4, lesson 4; notes/0001).
struct CoveringSurfel {
    FittedSurfel fitted;
    UnfilledVector<Covered> covered;
    /// Points that it does not explain, yet no farther than 9 sqrt(lambda) and 0.35 rho.
    std::vector<std::uint32_t> beside;
    std::vector<EdgeSign> edges;  ///< of points that it does not explain (notes/0008)
    bool edges_are_real = false;
    std::vector<EdgePoint> edge_points;  ///< where they are
    std::vector<AirPlace> air;  ///< where it stands in the air; of leaves
                                ///< that end early (notes/0012)
    bool explains_center = false;
    Vec3d lean;  ///< weighted mean of the points in the tangent plane, over rho: long at a border
    double breadth = 1;  ///< least RMS width of the points in the tangent
                         ///< plane, over rho: 0.5 on a surface, 0 on a line
    double middle = 0;  ///< share of the points within half of the radius: a quarter on a surface
    std::size_t n_aside = 0;  ///< points in the ball whose normals leave the height field
    Fallback fallback = Fallback::none;
    bool normals_disagree = false;
};

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

/// Whether a smooth surfel passes its centre by so far that it does not explain it, by more than
/// `clearly` of its radius.
bool misses_center(const FittedSurfel& surfel, double noise_variance, double clearly);

/// Adds the lists that were left out of a surfel, from the ball as its fit left it.
void list_points(const PointTree& points, const BallPoints<double>& ball, double noise_variance,
                 CoveringSurfel& surfel);

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
