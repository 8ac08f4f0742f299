#pragma once

#include "slim/shapes/shape.h"

#include <optional>

namespace slim {

struct FootPoint {
    Vec3d point;
    double signed_distance = 0;  ///< negative inside
    bool converged =
        false;  ///< the line to x is perpendicular to the surface to 1e-10 of the diagonal
};

/// Nearest point of the surface, by its closed form where the shape has one (at the apex of the
/// cone not `converged`). Else Newton's method on f(y) = 0, x - y parallel to grad f(y), started by
/// one gradient step, and by the end of plain gradient projection where that lies nearer; where
/// both end farther away than |f| / |grad f| lets expect, also by what a fan of 96 rays meets
/// first.
///
/// Exact (about 1e-12) for x nearer to the surface than its least radius of curvature and than half
/// the gap to another sheet. Elsewhere, and across a crease, it may be a stationary point that is
/// not the nearest, or not converge: then `point` is the result of plain gradient projection, on
/// the surface near x, and the distance is that to it. Never farther than that result is. Of the
/// sculpture's points moved along their normals by up to 1.4 % of L, 2 % of the feet are farther
/// than that, the worst 6 times. Cost: 6-10 jets near the surface.
FootPoint foot_point(const Shape& shape, const Vec3d& x);

/// foot_point, and where that did not converge, cannot be the nearest (beyond a centre of
/// curvature) or starts from afar, the nearest point of all that a search of the shape's box finds
/// (nearest_search.h): anywhere, also across a crease, in the middle of a shape and at any
/// distance.
///
/// returns  nothing where the distance is not known to 1e-3 of the diagonal (search_nearest):
/// farther than 1e30 diagonals; farther than
///          one diagonal, or not converged, from an open shape without a closed form (monkey)
/// cost     that of foot_point; with a search 0.1 to 10 ms
std::optional<FootPoint> nearest_point(const Shape& shape, const Vec3d& x);

/// foot_point(shape, x).signed_distance.
double signed_distance(const Shape& shape, const Vec3d& x);

}  // namespace slim
