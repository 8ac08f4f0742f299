#pragma once

#include "pipeline/render/render_config.h"
#include "raytrace/frame.h"
#include "raytrace/legend.h"

#include <cstdint>
#include <span>
#include <string>

namespace slim {

/// How one quantity becomes a false colour.
struct MapSpec {
    const char* title;
    int length_power;       ///< unit: length to this power; 0 for pure numbers
    bool is_signed;         ///< diverging about 0
    const char* high_note;
    const char* low_note;
};

/// The map of an AOV that is painted as one (mean, gauss, k1, k2, e1, e2, dk1_dt2, dk2_dt1, depth,
/// error, coverage, truth_distance), else null.
const MapSpec* map_spec(const std::string& aov);

/// What the smallest range that is worth showing is measured by.
struct MapScale {
    double diagonal = 1;
    double curvature_noise = 0;  ///< see curvature_noise.h
};

/// Range of an AOV: what --range fixes for it, else from the covered values (see percentile_of_abs;
/// of curvatures and their derivatives, where most are flat, from the others: radii below 10
/// diagonals, of curvatures no gentler than the fit's own). Of signed quantities it is about zero.
/// The smallest range of curvatures is what the fit makes of its noise, within radii of 40 and 2
/// diagonals, and one of 2 diagonals where most is flat and nothing else bent: radii of 80 and
/// more. Of "gauss" it is at least the square of the middle mean curvature (half of its integral
/// lies below), for which the frame holds that. Throws ConfigError on a bad --range.
///
/// frame  its hits; the values are one for each of its pixels
ValueRange map_range(const RenderConfig& config, const std::string& aov,
                     std::span<const float> values, const GBuffer& frame,
                     const MapScale& scale);

/// Throws ConfigError naming an entry of --range that is none, or is for an AOV that has no range.
void check_ranges(const RenderConfig& config);

/// Title, unit, notes, and arrow tips where hit values lie beyond the range.
Legend make_legend(const RenderConfig& config, const std::string& aov, const ValueRange& range,
                   std::span<const float> values, std::span<const std::uint8_t> hit);

/// viridis in n flat steps, one per level, for the range [lo - 1/2, lo + n - 1/2].
ColorMap stepped_viridis(int n);

}  // namespace slim
