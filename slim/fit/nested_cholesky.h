#pragma once

#include "slim/model/polynomial.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace slim {

/// Place of phi_i phi_j among the monomials in basis order.
std::size_t product_index(std::size_t i, std::size_t j);

/// One Cholesky factor serves every degree: the leading block of degree d is the factor of degree d
/// (NUMERICS 2.2).
///
/// Solves min sum G (w - phi^T a)^2 for all degrees up to `degree`, from sums in basis order
/// (`monomials`: n_coefficients(2 degree) of them; degree up to 4). A block of equal degree whose
/// pivots in the matrix scaled to unit diagonal fall below 1e-6 is dropped whole (NUMERICS 2.4,
/// rule 2).
class NestedCholesky {
public:
    NestedCholesky(int degree, std::span<const double> monomials, std::span<const double> heights,
                   double sq_height);
    /// From the whole matrix (symmetric, n_coefficients(degree) rows one after the other;
    /// lower half read).
    struct Matrix {
        std::span<const double> entries;
        std::size_t n;
    };
    NestedCholesky(int degree, const Matrix& matrix, std::span<const double> heights,
                   double sq_height);
    int rank_degree() const { return rank_degree_; }
    double sq_residual(int degree) const;
    /// What the terms of one degree take off the residual of the degrees below, <= rank_degree().
    double sq_gain(int degree) const;
    std::array<double, kMaxCoefficients> coefficients(int degree) const;
    /// Diagonal of A^-1, A the block of `degree`: times the variance of the heights' noise (and
    /// sum G^2 / sum G) it is the variance of the coefficients.
    std::array<double, kMaxCoefficients> inverse_diagonal(int degree) const;

    /// What the terms of one degree, as this system solves them, take off the residual of another,
    /// of the same points seen in fewer ways, beyond what lower degrees take there; and how many
    /// independent errors of that other system their errors amount to (degree + 1 if both are the
    /// same). degree <= rank_degree() of both.
    struct GainThere {
        double sq_gain, n_errors;
    };
    GainThere gain_in(const NestedCholesky& other, int degree) const;

private:
    template <class Entry>
    void factorise(int degree, const Entry& entry, std::span<const double> heights);

    int rank_degree_ = -1;  ///< -1: not even a constant (no weight)
    /// Room for the degree beyond a cubic that fit_ball_ahead looks at.
    static constexpr int kMost = n_coefficients(kMaxDegree + 1);
    double sq_height_;
    std::array<std::array<double, kMost>, kMost> factor_{};
    std::array<double, kMost> y_{};
    std::array<double, kMost> scale_{};
};

/// Variances of the coefficients of a degree over that of the heights' noise,
/// for sums of weights G.
template <class Moments>
std::array<double, kMaxCoefficients> spread_of(const Moments& moments, const NestedCholesky& solver,
                                               int degree) {
    auto spread = solver.inverse_diagonal(degree);
    for (double& v : spread) v *= moments.weight() / moments.n_effective();
    return spread;
}

}  // namespace slim
