#pragma once

#include "slim/shapes/shape.h"

namespace slim {

struct FootPoint {
    Vec3d point;
    double signed_distance = 0;  ///< negative inside
    bool converged = false;      ///< the two conditions below hold to 1e-10 of the diagonal
};

/// Nearest point of the surface: Newton's method on f(y) = 0, x - y parallel to grad f(y), started
/// by one gradient step.
///
/// Exact (about 1e-12) for x nearer to the surface than its least radius of curvature and than half
/// the gap to another sheet. Elsewhere, and across a crease, it may be a stationary point that is
/// not the nearest, or not converge: then `point` is the result of plain gradient projection, on
/// the surface near x, and the distance is that to it. Cost: 3-5 jets near the surface.
FootPoint foot_point(const Shape& shape, const Vec3d& x);

/// foot_point(shape, x).signed_distance.
double signed_distance(const Shape& shape, const Vec3d& x);

}  // namespace slim
