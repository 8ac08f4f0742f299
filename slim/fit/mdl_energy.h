#pragma once

#include "slim/fit/local_fit.h"
#include "slim/model/surfel_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slim {

/// A residual that floats do not tell from none: coordinates over the radius are rounded to 6e-8 of
/// it, and so is what a file keeps of a surfel. It grows with the ball: small balls would win on an
/// exact plane (notes/0021).
inline bool is_rounding(double sq_error, double radius) {
    const double step = std::numeric_limits<float>::epsilon() / 2 * radius;
    return sq_error < step * step;
}

/// The variance of normal noise of which a ball shows only `sq_error`: the weight falls along the
/// normal, too, as exp(-8 w^2 / rho^2), and 1 / shown = 1 / whole + 16 / rho^2. A ball that is as
/// thick as wide shows rho^2 / 16 whatever the noise; it counts for at most twenty times that
/// (slim/fit/notes/0005). Rounding counts for nothing.
inline double whole_variance(double sq_error, double radius) {
    if (is_rounding(sq_error, radius)) return 0;
    return sq_error / std::max(1 - 16 * sq_error / (radius * radius), 0.05);
}

/// E(rho) = eps^2 + lambda (T L / rho)^2, Ohtake 2005 eq. (3) with T a fraction of L (NUMERICS 3.1)
/// and eps^2 the whole variance.
struct MdlEnergy {
    double noise_variance;  ///< lambda, length^2
    double length;          ///< T_MDL * L

    double price(double radius) const {
        const double t = length / radius;
        return noise_variance * t * t;
    }
    double operator()(double sq_error, double radius) const {
        return whole_variance(sq_error, radius) + price(radius);
    }
    /// The energy of surfels that take `price` times the bytes of the one that T is meant for.
    MdlEnergy at_price(double price) const { return {noise_variance, length * std::sqrt(price)}; }
    /// E plus two standard errors of the estimate eps^2 (DESIGN 4.3).
    double upper_bound(const LocalFit& fit, double radius) const {
        const double freedom = std::max(fit.n_effective - n_coefficients(fit.degree), 0.5);
        return (*this)(fit.sq_error, radius) +
               2 * whole_variance(fit.sq_error, radius) * std::sqrt(2 / freedom);
    }
};

/// Bytes of a surfel of a degree in the file, its node included, over those of a quadratic one: the
/// description lengths that `--degree auto` compares (NUMERICS 2.4).
constexpr double degree_price(int degree) {
    constexpr auto bytes = [](int d) { return 4.0 * floats_per_surfel(d) + sizeof(TreeNode); };
    return bytes(degree) / bytes(2);
}

}  // namespace slim
