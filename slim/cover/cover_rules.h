#pragma once

#include "slim/cover/overlap.h"
#include "slim/fit/radius_ladder.h"
#include "slim/model/fitted_surfel.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <span>

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
    bool windows = false;  ///< the radius by the paper's windows, not the ladder (slim/fit/notes/0006)
    FitWeight weight = FitWeight::gauss;
    CoverReading reading = CoverReading::b;
    bool sharp = false;  ///< edges and corners may become surfels of two or three sheets
    std::function<bool(const Vec3d&)> owns;  ///< centres and points to cover; empty: all
    int first_level = 1;                ///< radii above this level's are left to others (coarse levels)
    int last_level = 48;                ///< and those below this one's
    std::span<const FittedSurfel> done; ///< surfels that cover already, of levels before first_level

    /// Where the degree is not chosen one by one: of internal surfels, which stand in for their children where
    /// these are a few pixels large, and of edges, whose price is that of quadratic sheets.
    int usual_degree() const { return ladder.choose_degree ? std::min(degree, 2) : degree; }
};

}  // namespace slim
