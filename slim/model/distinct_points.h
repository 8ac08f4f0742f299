#pragma once

#include "slim/model/point_block.h"

#include <cstdint>
#include <functional>

namespace slim {

/// Leaves one of the points that stand side by side at the very same place with normals within 45
/// degrees: a fit would take a score of copies for the points of a ball. It gets the direction of
/// the sum of their normals. Corners of faces that meet at an edge, and the sides of a sheet, are
/// places of several points. In Morton order all copies stand side by side, but for places that the
/// order does not tell apart.
///
/// is_counted  whether a copy left out counts
/// returns     how many do
/// cost        O(points) and no memory
std::uint64_t keep_distinct(PointBlock& points,
                            const std::function<bool(const Vec3d&)>& is_counted);

}  // namespace slim
