#pragma once

#include "slim/base/reporter.h"
#include "slim/cover/overlap.h"
#include "slim/cover/surfel_fit.h"
#include "slim/fit/radius_ladder.h"
#include "slim/model/fitted_surfel.h"
#include "slim/model/point_block.h"

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace slim {

/// What the fit of one set of points is asked for.
struct CoverRules {
    int degree = 2;
    double mdl_threshold = 0.01;  ///< T_MDL, fraction of `diagonal`
    double diagonal = 0;          ///< L of the whole job
    double noise_variance = 0;    ///< lambda
    double least_radius = 0;      ///< below it coordinates are rounding
    std::uint64_t seed = 0;
    LadderRules ladder;
    bool windows = false;  ///< the radius by the paper's windows, not the ladder (slim/fit/notes/0005)
    FitWeight weight = FitWeight::gauss;
    CoverReading reading = CoverReading::b;
    bool sharp = false;  ///< edges and corners may become surfels of two or three sheets
    std::function<bool(const Vec3d&)> owns;  ///< centres and points to cover; empty: all
    int first_level = 1;                ///< radii above this level's are left to others (coarse levels)
    int last_level = 48;                ///< and those below this one's
    std::span<const FittedSurfel> done; ///< surfels that cover already, of levels before first_level
};

/// Counts of what happened, each fallback by cause.
struct CoverCounts {
    std::uint64_t leaves = 0, internals = 0, levels = 0;
    std::uint64_t saturated = 0, forced = 0, normals_disagree = 0;
    std::uint64_t contrary = 0;     ///< leaves whose ball ends at normals of a fold or another sheet
    std::uint64_t unexplained = 0;  ///< points that no surfel explains, not even their own: dropped
    std::uint64_t isolated = 0;     ///< strays, with too few neighbours about rho_0: dropped
    std::uint64_t sharp_edges = 0, sharp_corners = 0;  ///< leaves of two and of three sheets
    std::uint64_t sharp_rungs = 0;  ///< balls that were tried with more than one sheet
    std::uint64_t recentred = 0;    ///< leaves of border points, moved inwards
    std::uint64_t evaluated = 0, discarded = 0, rungs = 0, refinements = 0, point_visits = 0;
    std::array<std::uint64_t, kFallbacks> fallbacks{};
    std::array<std::uint64_t, kMaxDegree + 1> degrees{};

    CoverCounts& operator+=(const CoverCounts& b);
};

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
