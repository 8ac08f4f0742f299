#pragma once

#include "slim/base/reporter.h"
#include "slim/cover/cover_counts.h"
#include "slim/cover/cover_rules.h"
#include "slim/fit/edge_share.h"
#include "slim/model/fitted_surfel.h"
#include "slim/model/point_block.h"

#include <cstdint>
#include <vector>

namespace slim {

struct Cover {
    std::vector<FittedSurfel> surfels;  ///< leaves and internal ones, in the order of acceptance;
                                        ///< none with CoverRules::keep
    std::vector<std::uint64_t> dropped; ///< ids of points that count as
                                        ///< isolated, unexplained or beside
    CoverCounts counts;
    EdgeShare edges;  ///< what CoverRules::ask_for_edges found: sharp if edges.are_features()
    bool are_on_faces = false;  ///< points_on_faces() took their place: a part in noise
};

/// Covers points by surfels, level by level (Ohtake 2005 sec. 2 with the ladder of DESIGN 4).
///
/// A point is covered when the leaves' weights add up to gamma at it and it lies in the core of one
/// (NUMERICS 3.4, reading B unless the rules say another). At level k, centres are open points by
/// random priority; one whose best radius reaches the level's lower end becomes a leaf, any other
/// an internal surfel of radius rho_r, and waits. Points need normals; a point without one takes
/// part in fits but is no centre's side. Deterministic: the result is that of one centre after the
/// other, by priority; they are searched several at once, and what an accepted one forestalls is
/// thrown away. What becomes of a centre therefore depends on its surroundings alone, however much
/// of the job's cloud is here (notes/0005). Cost: about one radius search (10 us) a surfel, one
/// visit a point and leaf that covers it. With last_level set,
/// points that wait for finer levels stay uncovered.
Cover cover_points(const PointBlock& points, const CoverRules& rules, Reporter& reporter);

}  // namespace slim
