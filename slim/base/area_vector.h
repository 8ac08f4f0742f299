#pragma once

#include "slim/base/vec.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace slim {

/// Along a polygon's normal (right-handed), twice its area long: by triangles about its first
/// corner. Zero for fewer than three corners; of a polygon that is not flat the sum of its
/// triangles.
inline Vec3d area_vector(std::span<const Vec3d> corners) {
    Vec3d sum;
    for (std::size_t k = 2; k < corners.size(); ++k)
        sum += cross(corners[k - 1] - corners[0], corners[k] - corners[0]);
    return sum;
}

/// The same of corners that are indices into `position`.
inline Vec3d area_vector(std::span<const Vec3d> position, std::span<const std::uint32_t> corner) {
    Vec3d sum;
    for (std::size_t k = 2; k < corner.size(); ++k)
        sum += cross(position[corner[k - 1]] - position[corner[0]],
                     position[corner[k]] - position[corner[0]]);
    return sum;
}

}  // namespace slim
