#include "slim/fit/nested_cholesky.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr double kLeastPivot = 1e-6;
constexpr std::size_t kMostTerms = n_coefficients(kMaxDegree + 1);

/// Exponent of v of basis function k, and its degree.
struct Exponents {
    int degree, v;
};
constexpr Exponents exponents(std::size_t k) {
    int d = 0, first = 0;
    while (first + d + 1 <= static_cast<int>(k)) first += ++d;
    return {d, static_cast<int>(k) - first};
}

/// Place of phi_i phi_j among the monomials.
constexpr std::size_t index_of_product(std::size_t i, std::size_t j) {
    const Exponents a = exponents(i), b = exponents(j);
    const int d = a.degree + b.degree;
    return static_cast<std::size_t>(d * (d + 1) / 2 + a.v + b.v);
}

constexpr auto make_product_table() {
    std::array<std::array<std::uint8_t, kMostTerms>, kMostTerms> table{};
    for (std::size_t i = 0; i < kMostTerms; ++i)
        for (std::size_t j = 0; j < kMostTerms; ++j)
            table[i][j] = static_cast<std::uint8_t>(index_of_product(i, j));
    return table;
}
constexpr auto kProduct = make_product_table();

}  // namespace

std::size_t product_index(std::size_t i, std::size_t j) { return kProduct[i][j]; }

NestedCholesky::NestedCholesky(int degree, std::span<const double> monomials,
                               std::span<const double> heights, double sq_height)
    : sq_height_(sq_height) {
    factorise(
        degree, [&](std::size_t i, std::size_t j) { return monomials[kProduct[i][j]]; }, heights);
}

NestedCholesky::NestedCholesky(int degree, const Matrix& matrix, std::span<const double> heights,
                               double sq_height)
    : sq_height_(sq_height) {
    factorise(
        degree, [&](std::size_t i, std::size_t j) { return matrix.entries[i * matrix.n + j]; },
        heights);
}

template <class Entry>
void NestedCholesky::factorise(int degree, const Entry& entry, std::span<const double> heights) {
    // of the pivots: a division takes as long as the rest of a term
    std::array<double, kMost> inverse;
    for (int d = 0; d <= degree; ++d) {
        const auto first = static_cast<std::size_t>(d * (d + 1) / 2);
        for (std::size_t i = first; i < first + static_cast<std::size_t>(d) + 1; ++i) {
            if (!(entry(i, i) > 0)) return;
            scale_[i] = 1 / std::sqrt(entry(i, i));
            double rest = 1;
            double y = heights[i] * scale_[i];
            for (std::size_t j = 0; j < i; ++j) {
                double a = entry(i, j) * scale_[i] * scale_[j];
                for (std::size_t k = 0; k < j; ++k) a -= factor_[i][k] * factor_[j][k];
                factor_[i][j] = a * inverse[j];
                rest -= factor_[i][j] * factor_[i][j];
                y -= factor_[i][j] * y_[j];
            }
            if (!(rest > kLeastPivot)) return;
            factor_[i][i] = std::sqrt(rest);
            inverse[i] = 1 / factor_[i][i];
            y_[i] = y * inverse[i];
        }
        rank_degree_ = d;
    }
}

double NestedCholesky::sq_residual(int degree) const {
    double rss = sq_height_;
    for (int i = 0; i < n_coefficients(degree); ++i)
        rss -= y_[static_cast<std::size_t>(i)] * y_[static_cast<std::size_t>(i)];
    return std::max(rss, 0.0);
}

double NestedCholesky::sq_gain(int degree) const {
    double gain = 0;
    for (auto i = static_cast<std::size_t>(n_coefficients(degree - 1));
         i < static_cast<std::size_t>(n_coefficients(degree)); ++i)
        gain += y_[i] * y_[i];
    return gain;
}

std::array<double, kMaxCoefficients> NestedCholesky::coefficients(int degree) const {
    std::array<double, kMaxCoefficients> a{};
    for (auto i = static_cast<std::size_t>(n_coefficients(degree)); i-- > 0;) {
        double sum = y_[i];
        for (auto j = static_cast<std::size_t>(n_coefficients(degree)); --j > i;)
            sum -= factor_[j][i] * a[j];
        a[i] = sum / factor_[i][i];
    }
    for (std::size_t i = 0; i < kMaxCoefficients; ++i) a[i] *= scale_[i];
    return a;
}

std::array<double, kMaxCoefficients> NestedCholesky::inverse_diagonal(int degree) const {
    const auto n = static_cast<std::size_t>(n_coefficients(degree));
    std::array<double, kMaxCoefficients> out{};
    for (std::size_t c = 0; c < n; ++c) {
        // Column c of L^-1; the squares of row k of its transpose add up to (A^-1)_kk.
        std::array<double, kMaxCoefficients> x{};
        for (std::size_t i = c; i < n; ++i) {
            double sum = i == c ? 1.0 : 0.0;
            for (std::size_t j = c; j < i; ++j) sum -= factor_[i][j] * x[j];
            x[i] = sum / factor_[i][i];
            out[c] += x[i] * x[i];
        }
    }
    for (std::size_t k = 0; k < n; ++k) out[k] *= scale_[k] * scale_[k];
    return out;
}

/// The coefficients a of the block are D L^-T y, D the scale, with covariance D L^-T L^-1 D; there
/// they take off |L'^T D'^-1 a|^2 = |X^T y|^2, X = L^-1 D D'^-1 L'.
NestedCholesky::GainThere NestedCholesky::gain_in(const NestedCholesky& other, int degree) const {
    const auto first = static_cast<std::size_t>(n_coefficients(degree - 1));
    const auto end = static_cast<std::size_t>(n_coefficients(degree));
    GainThere out{0, 0};
    for (std::size_t c = first; c < end; ++c) {
        std::array<double, kMost> x{};
        double along = 0;
        for (std::size_t i = first; i < end; ++i) {
            double sum = i >= c ? other.factor_[i][c] * scale_[i] / other.scale_[i] : 0;
            for (std::size_t j = first; j < i; ++j) sum -= factor_[i][j] * x[j];
            x[i] = sum / factor_[i][i];
            along += x[i] * y_[i];
            out.n_errors += x[i] * x[i];
        }
        out.sq_gain += along * along;
    }
    return out;
}

}  // namespace slim
