#pragma once

#include "slim/base/vec.h"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace slim {

using Corners = std::array<std::size_t, 3>;
using Triangle = std::array<Vec3d, 3>;

/// Of all triangles of the fan, which are what gets points: of a folded face more than its vector's
/// length.
double fan_area(std::span<const Vec3d> corners);

/// The longest of a face's edges and ways across from its first corner: what its vertices leave
/// open.
double extent_of(std::span<const Vec3d> corners);

/// Triangles that cover a face once: a fan, or ears cut off one by one where it is concave
/// (Meisters 1975). None if its outline crosses itself, or of a concave one of too many corners.
/// cost  O(n^3) of a concave face
std::vector<Corners> triangles_of(std::span<const Vec3d> corners, const Vec3d& area);

}  // namespace slim
