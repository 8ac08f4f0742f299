#pragma once

#include "slim/fit/ball_points.h"
#include "slim/model/surfel.h"

#include <vector>

namespace slim {

/// A place of a surfel's core that stands off the surface which the points show there; in its
/// tangent plane, over rho.
struct AirPlace {
    float u, v;
    bool far;  ///< by so much, or so far from all points, that no ball should be made larger for it
};

/// Where the core of a smooth surfel stands in the air: past an edge, over a border, off a bend
/// (notes/0012). The nearest point of the ball, whatever its sheet, says so by its plane; one
/// without a normal by its distance alone. ball: all points of the surfel's ball, those set aside
/// too. Cost: up to 208 places times the points of the ball, by lanes.
std::vector<AirPlace> air_places(const Surfel& surfel, const BallPoints<double>& ball);

}  // namespace slim
