#pragma once

#include "slim/base/vec.h"
#include "slim/fit/ball_points.h"
#include "slim/model/surfel.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace slim {

/// Share of the way from one cluster's normal to another's (in 1 - cos) within which a normal is
/// neither's.
inline constexpr double kAmbiguous = 0.4;

/// How far a ball's normals are from one: 1 - |sum n| / n over the points that have one; 0 on a
/// plane, 0.29 on both sides of a right-angled edge. Cost: one pass, a few flops a point.
template <class T>
double normal_spread(const BallPoints<T>& points);

/// The spread of normals of an edge of 30 degrees through the middle of a ball.
inline constexpr double kLeastSpread = 0.03;

/// Whether it may pay to look for sheets: the normals spread by more than kLeastSpread, and two or
/// three groups of them hold most of that spread, which those of a curved surface do not (two
/// halves of an arc keep a quarter, of a cap half). Judged by about 48 of the points.
/// share: of what groups may leave of the spread; smaller is stricter
template <class T>
bool shows_edge(const BallPoints<T>& points, double share = 1);

/// Whether up to kMostSheets groups of normals hold all but a hundredth of their spread, as those
/// of flat faces do at any angle from 6 degrees on. Judged by about 48 of the points.
template <class T>
bool shows_faces(const BallPoints<T>& points);

struct NormalClusters {
    std::array<Vec3d, kMostSheets> normal;  ///< unit
};

/// Splits a ball's normals into k = 2 to kMostSheets clusters: k-means, the seeds being the normal
/// farthest from the mean, the one farthest from that, the one farthest from both, and so on.
/// `member[i]` is the bit of the cluster of point i, or 0 where its normal lies between two (an
/// edge's own vertices) or is missing. False if one has fewer than 3 points or 4 % of all, or if
/// two are less than 30 degrees apart: 6 degrees where they hardly spread, as those of flat faces.
/// More than three must be such (notes/0017).
template <class T>
bool cluster_normals(const BallPoints<T>& points, std::size_t k, NormalClusters& clusters,
                     std::vector<std::uint8_t>& member);

}  // namespace slim
