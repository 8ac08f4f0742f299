#pragma once

#include "slim/base/frame.h"
#include "slim/base/vec.h"
#include "slim/model/polynomial.h"

namespace slim {

/// One surfel (Ohtake 2005 eq. (1)), decoded to doubles. The surface inside the ball is
/// f(x) = w - P(u, v) = 0 with (u, v, w) = frame.local_from_world(x - center) / support_radius.
struct Surfel {
    Vec3d center;           ///< local frame of the job (world minus the job's origin)
    double support_radius;  ///< rho
    Frame<double> frame;    ///< normal outwards
    Polynomial<double> polynomial;
    int degree = 2;         ///< what it was fitted with, after fallbacks: 0..3
};

/// The share of rho in which stage 1 looks for the first hit (alpha, paper sec. 3).
inline constexpr double kTrim = 2.0 / 3.0;
/// The share of rho up to which a point belongs to a surfel: one farther off is neither covered by it nor
/// blended with it, however poor its fit.
inline constexpr double kBelongs = 0.3;
/// Least overlap of a covered point (gamma, paper sec. 2).
inline constexpr double kCoverage = 0.1;
/// Golden ratio g of the radius ladder (paper eq. (5)).
inline constexpr double kGoldenRatio = 0.61803398874989484820;

}  // namespace slim
