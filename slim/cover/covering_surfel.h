#pragma once

#include "slim/base/unfilled_vector.h"
#include "slim/base/vec.h"
#include "slim/cover/air_places.h"
#include "slim/fit/local_fit.h"
#include "slim/model/fitted_surfel.h"

#include <cstddef>
#include <cstdint>
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
    PackedRims void_rims = {};  ///< before what it would bridge, of what covers
                                ///< no points beyond them (notes/0024)
    bool explains_center = false;
    Vec3d lean;  ///< weighted mean of the points in the tangent plane, over rho: long at a border
    double breadth = 1;  ///< least RMS width of the points in the tangent
                         ///< plane, over rho: 0.5 on a surface, 0 on a line
    double middle = 0;  ///< share of the points within half of the radius: a quarter on a surface
    bool on_wire = false;  ///< its points are a wire's (is_wire): it ends beside the last of them
    std::size_t n_aside = 0;  ///< points in the ball whose normals leave the height field
    Fallback fallback = Fallback::none;
    bool normals_disagree = false;
};

}  // namespace slim
