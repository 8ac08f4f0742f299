#pragma once

#include "slim/base/vec.h"
#include "slim/fit/ball_points.h"
#include "slim/model/surfel.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace slim {

/// Share of the way from one cluster's normal to another's (in 1 - cos) within which a normal is neither's.
inline constexpr double kAmbiguous = 0.4;

struct NormalClusters {
    std::array<Vec3d, kMostSheets> normal;  ///< unit
};

/// Splits a ball's normals into k = 2 or 3 clusters: k-means, the seeds being the normal farthest from the
/// mean, the one farthest from that, and the one farthest from both. `member[i]` is the bit of the cluster of
/// point i, or 0 where its normal lies between two (an edge's own vertices) or is missing.
/// False if two clusters are less than 30 degrees apart or one has fewer than 6 points or 4 % of all.
template <class T>
bool cluster_normals(const BallPoints<T>& points, std::size_t k, NormalClusters& clusters,
                     std::vector<std::uint8_t>& member);

}  // namespace slim
