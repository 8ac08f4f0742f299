#pragma once

#include "slim/fit/local_fit.h"
#include "slim/model/surfel_tree.h"

#include <algorithm>
#include <cmath>

namespace slim {

/// E(rho) = eps^2 + lambda (T L / rho)^2, Ohtake 2005 eq. (3) with T a fraction of L (NUMERICS 3.1).
struct MdlEnergy {
    double noise_variance;  ///< lambda, length^2
    double length;          ///< T_MDL * L

    double operator()(double sq_error, double radius) const {
        const double t = length / radius;
        return sq_error + noise_variance * t * t;
    }
    /// The energy of surfels that take `price` times the bytes of the one that T is meant for.
    MdlEnergy at_price(double price) const { return {noise_variance, length * std::sqrt(price)}; }
    /// E plus two standard errors of the estimate eps^2 (DESIGN 4.3).
    double upper_bound(const LocalFit& fit, double radius) const {
        const double freedom = std::max(fit.n_effective - n_coefficients(fit.degree), 0.5);
        return (*this)(fit.sq_error, radius) + 2 * fit.sq_error * std::sqrt(2 / freedom);
    }
};

/// Bytes of a surfel of a degree in the file, its node included, over those of a quadratic one: the
/// description lengths that `--degree auto` compares (NUMERICS 2.4).
constexpr double degree_price(int degree) {
    constexpr auto bytes = [](int d) { return 4.0 * floats_per_surfel(d) + sizeof(TreeNode); };
    return bytes(degree) / bytes(2);
}

}  // namespace slim
