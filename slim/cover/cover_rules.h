#pragma once

#include "slim/cover/overlap.h"
#include "slim/fit/mdl_energy.h"
#include "slim/fit/radius_ladder.h"
#include "slim/model/fitted_surfel.h"
#include "slim/model/surfel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>

namespace slim {

/// rho_r of a level: rho_0 g^(level - 1), rho_0 = L / 10 (paper eq. (5)).
inline double level_radius(double diagonal, int level) {
    return diagonal / 10 * std::pow(kGoldenRatio, level - 1);
}

/// The level, of [first, last], that accepts leaves of a radius.
inline int level_of(double radius, double diagonal, int first, int last) {
    int level = first;
    while (level < last && radius < level_radius(diagonal, level + 2)) ++level;
    return level;
}

/// Finer than any scan: rho_0 g^47 = 1e-11 L.
inline constexpr int kLastLevel = 48;

/// How far a point may be off in clean clouds: the larger of a share of T L and so many
/// sqrt(lambda) (notes/0016).
inline constexpr double kFarthestOfPrice = 0.38, kFarthestOfNoise = 5;

/// What the fit of one set of points is asked for.
struct CoverRules {
    int degree = 2;
    double mdl_threshold = 0.01;  ///< T_MDL, fraction of `diagonal`
    double diagonal = 0;          ///< L of the whole job
    double noise_variance = 0;    ///< lambda
    double least_radius = 0;      ///< below it coordinates are rounding
    std::uint64_t seed = 0;
    LadderRules ladder;
    bool windows = false;  ///< the radius by the paper's windows, not
                           ///< the ladder (slim/fit/notes/0006)
    FitWeight weight = FitWeight::gauss;
    CoverReading reading = CoverReading::b;
    bool sharp = false;  ///< edges and corners may become surfels of several sheets
    bool ask_for_edges = false;  ///< the points decide in place of `sharp` (edge_share)
    std::uint64_t n_points = 0;  ///< of the whole job; 0: as many as are here
    bool follow_normals = false;  ///< fits follow the points' normals as well (slim/fit/notes/0007)
    bool are_estimated = false;  ///< most of those normals were made from neighbouring points
    /// Leaves are fitted a second time, to what their blend leaves over (blend_refit.h),
    /// and so overlap less.
    bool refits = false;
    /// Noise of a typical place, length^2: edges add nothing to it, as they do to lambda.
    double typical_variance = 0;
    /// Strays to the volume: where points are sparser than usual and no denser than a few times
    /// that, they must show a surface (notes/0019). 0: none.
    double stray_density = 0;
    /// What lies on a line is a wire, no scan line whose next ones are far: a leaf of it is small
    /// and narrow.
    bool lines_are_wires = false;
    double spacing = 0;  ///< square root of the area that one of the job's
                         ///< points usually has; 0: as these have
    double share = 1;    ///< of the job's points that are here, by
                         ///< in_share(); what < 1 does not resolve waits
    std::function<bool(const Vec3d&)> owns;  ///< centres of surfels to keep
                                             ///< and to count; empty: all
    int first_level = 1;                ///< radii above this level's are left
                                        ///< to others (coarse levels)
    int last_level = kLastLevel;        ///< and those below this one's
    std::span<const std::uint64_t> dropped; ///< ids of points that those levels dropped
    int rungs_above = 0;                ///< of a first_level > 1: leaves may be
                                        ///< so many rungs larger than it
    double provisional = 0;  ///< surfels of last_level up to this radius
                             ///< serve its larger leaves only, and go
    SurfelVisit keep;        ///< takes surfels as they are accepted; empty: Cover::surfels does
    SurfelSource done; ///< surfels that cover already, of levels before first_level; empty: none

    /// Finest rung of the ladder that leaves may not exceed:
    /// fine levels know no points beyond their halo.
    int top_rung() const { return std::max(0, first_level - 1 - rungs_above); }
    MdlEnergy energy() const { return {noise_variance, mdl_threshold * diagonal}; }
    bool is_sample() const { return share < 1; }
    /// A second fit wants all leaves: not where finer levels are left to others.
    bool fits_again() const { return refits && last_level == kLastLevel; }
    /// How far a point may be off where leaves are fitted again (notes/0016); length.
    double farthest() const {
        return std::max(kFarthestOfPrice * mdl_threshold * diagonal,
                        kFarthestOfNoise * std::sqrt(noise_variance));
    }
    /// Least overlap of a covered point.
    float coverage() const { return refits ? kRefittedCoverage : static_cast<float>(kCoverage); }

    /// Where the degree is not chosen one by one: of internal surfels, which stand in for their
    /// children where these are a few pixels large, and of edges,
    /// whose price is that of quadratic sheets.
    int usual_degree() const { return ladder.choose_degree ? std::min(degree, 2) : degree; }
};

}  // namespace slim
