#pragma once

#include "slim/base/reporter.h"
#include "slim/cover/cover_counts.h"
#include "slim/cover/cover_rules.h"
#include "slim/model/fitted_surfel.h"
#include "slim/model/point_block.h"

#include <vector>

namespace slim {

/// rho_r of a level: rho_0 g^(level - 1), rho_0 = L / 10 (paper eq. (5)).
double level_radius(double diagonal, int level);

struct Cover {
    std::vector<FittedSurfel> surfels;  ///< leaves and internal ones, in the order of acceptance
    CoverCounts counts;
};

/// Covers points by surfels, level by level (Ohtake 2005 sec. 2 with the ladder of DESIGN 4).
///
/// A point is covered when the leaves' weights add up to gamma at it and it lies in the core of one
/// (NUMERICS 3.4, reading B unless the rules say another). At level k, centres are open points by random priority; one whose best radius
/// reaches the level's lower end becomes a leaf, any other an internal surfel of radius rho_r, and waits.
/// Points need normals; a point without one takes part in fits but is no centre's side.
/// Deterministic: centres are searched in batches of fixed size, accepted one by one in order.
/// Cost: about one radius search (10 us) a surfel, one visit a point and leaf that covers it.
/// With last_level set, points that wait for finer levels stay uncovered.
Cover cover_points(const PointBlock& points, const CoverRules& rules, Reporter& reporter);

}  // namespace slim
