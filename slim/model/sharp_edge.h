#pragma once

#include "slim/base/vec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

namespace slim {

/// A point of an edge, frame of the job.
struct EdgePoint {
    Vec3d point;
    Vec3f tangent;                ///< unit, towards the next point
    std::array<Vec3f, 2> normal;  ///< of the two faces, unit, outwards

    /// By how much the normal turns across the edge: 180 degrees less the dihedral angle, 0 where
    /// flat.
    float turn_deg() const {
        return std::acos(std::clamp(dot(normal[0], normal[1]), -1.0f, 1.0f)) * 180 /
               std::numbers::pi_v<float>;
    }
};

inline constexpr std::uint32_t kNoCorner = 0xffffffffu;

/// A sharp edge of a model: where two sheets of its surfels meet, over all surfels that show it,
/// from one corner or end of data to the next. A closed one does not repeat its first point.
struct SharpEdge {
    bool convex = true;
    bool closed = false;
    std::size_t n_leaves = 0;  ///< surfels that hold it and that no edge before it passed
    std::array<std::uint32_t, 2> corner{
        kNoCorner, kNoCorner};  ///< numbers of the corners that it begins and ends at
    std::vector<EdgePoint> points;                   ///< at least 2
};

}  // namespace slim
