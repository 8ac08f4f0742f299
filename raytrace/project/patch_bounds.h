#pragma once

#include "raytrace/project/surfel_lanes.h"

namespace slim {

/// The viewing direction seen from some surfels.
struct Heading {
    DoubleV along, across;  ///< its parts along the normal and in the plane

    explicit Heading(const Vec3D& normal);
};

/// What surfels' surfaces can reach: the parts of balls between two planes across their normals. A
/// surfel is a pancake, so this is much less than the ball where it is seen from the side.
struct PatchBounds {
    DoubleV radius;
    DoubleV low, high;  ///< along the normal, from the centre

    /// How far they reach in a direction from the centre (`forth`), or against it.
    DoubleV support(const Heading& h, bool forth) const;
};

/// Of the surfaces w = P(u, v) inside `share` of the balls.
PatchBounds patch_bounds(const SurfelLanes& surfels, double share);

}  // namespace slim
