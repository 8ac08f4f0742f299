#pragma once

#include "slim/base/vec.h"
#include "slim/neighbors/point_tree.h"

namespace slim {

/// Along each axis the step that coordinates were rounded to, in their unit; zero: none is seen. Of
/// up to 4096 points evenly along the curve all must lie on one lattice, and on four of its places
/// at least. Points that were sampled on a grid (terrain models, voxels, corners of drawn parts)
/// lie on lattices, too, but were not rounded to them: two or more steps of a third of the points'
/// distance are such a grid, unless some points fall in one place, and do not count. Cost: a sort
/// of the sample by each axis.
Vec3d coordinate_steps(const PointTree& points);

/// Squared noise along a unit normal of coordinates rounded to steps: uniform, step^2 / 12 along
/// each axis.
double rounding_noise(const Vec3d& steps, const Vec3d& normal);

}  // namespace slim
