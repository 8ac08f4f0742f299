#pragma once

#include "slim/model/surfel.h"
#include "slim/smooth/wide_fit.h"

#include <array>
#include <vector>

namespace slim {

/// A quadratic fitted about a place, and what is known of how far its middle is off;
/// lengths along its normal.
struct PlacedFit {
    Surfel surfel;
    double radius = 0;              ///< of the disc
    double lift = 0;                ///< as WideFit has it
    double sq_lift_error = 0;       ///< zero: the lift is not known
    double height_by_noise = 0;     ///< what noise of the feet adds to the mean height over a place
    std::array<double, 2> turn{};   ///< as WideFit has it
    double sq_turn_error = 0;
};

/// What noise of the feet adds to the mean height over a place of a disc's middle: s^2 H for noise
/// s of any direction (Fuller 1987, errors in variables; notes/0009).
double height_by_noise_of_feet(const WideFit& fit, double radius);

/// Takes off each fit's height what noise of the feet adds, and adds what degrees 3 and 4 would, as
/// a mean over the fits within 2.2 radii that face as it does: neighbours' noise in it cancels,
/// most of the bias is common to them. Turns it by the share of what they add to its slopes that is
/// not noise, as its neighbours show: where that is large, the blend's normals would have the fits'
/// own bias, which cancels in heights alone. In parallel, the same for any thread count. Cost: some
/// 200 fits about each; 330 bytes a fit while it runs.
/// fits  of each leaf
void lift_fits(std::vector<std::vector<PlacedFit>>& fits);

}  // namespace slim
