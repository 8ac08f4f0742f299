#pragma once

#include "slim/model/surfel.h"

#include <vector>

namespace slim {

// What pictures draw of a smooth leaf: its surface within kHitTrim of its radius, up to its rims.

/// The place of its surface just beyond (0.03 of its radius), in direction (u, v), unit, of its
/// tangent plane; from its centre, over its radius.
Vec3d place_beyond(const Surfel& leaf, double u, double v);

/// Places of the points' frame that lie spread over it, some 60.
std::vector<Vec3d> drawn_places(const Surfel& leaf);

/// Whether a leaf that faces the same way is drawn at a place, or up to 0.3 of its radius above or
/// below it. Of a sharp leaf the whole core counts. normal: unit, of what is to be drawn there
bool is_drawn_at(const Surfel& leaf, const Vec3d& place, const Vec3d& normal);

}  // namespace slim
