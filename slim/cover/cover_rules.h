#pragma once

#include "slim/fit/radius_ladder.h"
#include "slim/model/fitted_surfel.h"

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
    bool sharp = false;  ///< edges and corners may become surfels of two or three sheets
    std::function<bool(const Vec3d&)> owns;  ///< centres and points to cover; empty: all
    int first_level = 1;                ///< radii above this level's are left to others (coarse levels)
    int last_level = 48;                ///< and those below this one's
    std::span<const FittedSurfel> done; ///< surfels that cover already, of levels before first_level
};

}  // namespace slim
