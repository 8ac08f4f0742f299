#pragma once

#include "slim/base/frame.h"
#include "slim/base/vec.h"
#include "slim/cover/covering_surfel.h"
#include "slim/fit/ball_normal.h"
#include "slim/fit/ball_points.h"
#include "slim/neighbors/point_tree.h"

#include <span>

namespace slim {

/// Cosine between a point's normal and a surfel's below which the point may be an edge's:
/// 30 degrees.
inline constexpr double kEdgeCos = 0.866;

/// How the points that take part lie along the tangent plane, over rho.
struct Footprint {
    Vec3d lean;          ///< weighted mean; 0.2 at a straight border
    double breadth = 0;  ///< least RMS width about the mean
    double middle = 0;   ///< share within half of the radius
};

Footprint footprint_of(const BallPoints<double>& ball, const Frame<double>& frame);

/// Whether a smooth surfel passes its centre by so far that it does not explain it, by more than
/// `clearly` of its radius.
bool misses_center(const FittedSurfel& surfel, double noise_variance, double clearly);

/// Adds the signs of an acute edge, whose other face is among what was set aside as facing away:
/// the two sides of a sheet stand back to back, these do not (slim/fit/notes/0018).
void list_acute_edges(const BallPoints<double>& ball, std::span<const SetAside<double>> aside,
                      CoveringSurfel& out);

/// Adds the lists that were left out of a surfel, from the ball as its fit left it.
void list_points(const PointTree& points, const BallPoints<double>& ball, double noise_variance,
                 CoveringSurfel& surfel);

}  // namespace slim
