#include "slim/smooth/nested_disc.h"

#include "slim/fit/nested_cholesky.h"
#include "slim/model/weight_kernel.h"

#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

namespace slim {
namespace {

constexpr double kLeastPivot = 1e-6;

/// Mean of u^a v^b over the unit circle.
double circle_mean(int a, int b) {
    if (a % 2 != 0 || b % 2 != 0) return 0;
    double mean = 1;
    for (int i = a - 1; i > 0; i -= 2) mean *= i;
    for (int i = b - 1; i > 0; i -= 2) mean *= i;
    for (int i = a + b; i > 0; i -= 2) mean /= i;
    return mean;
}

/// Mean of u^a v^b over the disc of radius kCore.
double core_mean(int a, int b) {
    return circle_mean(a, b) * std::pow(kCore, a + b) * 2 / (a + b + 2);
}

/// Mean of u^a v^b under weight_kernel() over the disc of twice kCore,
/// by the midpoints of rings of equal area.
double weighted_mean(int a, int b) {
    constexpr int kRings = 4096;
    double sum = 0, all = 0;
    for (int k = 0; k < kRings; ++k) {
        const double sq = (k + 0.5) / kRings, weight = weight_kernel(sq);
        all += weight, sum += weight * std::pow(sq, 0.5 * (a + b));
    }
    return circle_mean(a, b) * std::pow(2 * kCore, a + b) * sum / all;
}

}  // namespace

template <int Degree>
struct NestedDisc<Degree>::Tables {
    static constexpr std::size_t kEven = Degree == 2 ? 4 : 9;
    std::array<std::array<std::size_t, kAll>, kAll>
        product;                                        // places of phi_i phi_j among the monomials
    std::array<std::size_t, kEven> even;                // terms of even degree
    std::array<std::array<double, kEven>, kEven> core;  // means of their products over the core
    std::array<double, kAll> blended;                   // weighted means of the monomials

    Tables() {
        std::vector<std::pair<int, int>> power;
        for (int d = 0; power.size() < kAll; ++d)
            for (int b = 0; b <= d; ++b) power.emplace_back(d - b, b);
        for (std::size_t i = 0; i < kAll; ++i)
            for (std::size_t j = 0; j < kAll; ++j) product[i][j] = product_index(i, j);
        for (std::size_t i = 0; i < kAll; ++i)
            blended[i] = weighted_mean(power[i].first, power[i].second);
        std::size_t n = 0;
        for (std::size_t i = 0; i < kAll; ++i)
            if ((power[i].first + power[i].second) % 2 == 0) even[n++] = i;
        for (std::size_t i = 0; i < kEven; ++i)
            for (std::size_t j = 0; j < kEven; ++j) {
                const auto [ai, bi] = power[even[i]];
                const auto [aj, bj] = power[even[j]];
                core[i][j] = core_mean(ai + aj, bi + bj);
            }
    }
};

template <int Degree>
auto NestedDisc<Degree>::tables() -> const Tables& {
    static const Tables tables;
    return tables;
}

template <int Degree>
std::optional<NestedDisc<Degree>> NestedDisc<Degree>::solve(const Moments<Degree>& m) {
    NestedDisc out;
    if (!out.factorise(m)) return std::nullopt;
    out.invert_factor();
    for (std::size_t i = 0; i < kAll; ++i) {
        out.y_[i] = 0;
        for (std::size_t k = 0; k <= i; ++k)
            out.y_[i] += out.inverse_[i][k] * out.scale_[k] * m.height[k];
    }
    return out;
}

template <int Degree>
bool NestedDisc<Degree>::factorise(const Moments<Degree>& m) {
    const auto& product = tables().product;
    for (std::size_t i = 0; i < kAll; ++i) {
        const double diagonal = m.monomial[product[i][i]];
        if (!(diagonal > 0)) return false;
        scale_[i] = 1 / std::sqrt(diagonal);
    }
    for (std::size_t i = 0; i < kAll; ++i)
        for (std::size_t j = 0; j <= i; ++j) {
            double rest = i == j ? 1 : scale_[i] * scale_[j] * m.monomial[product[i][j]];
            for (std::size_t k = 0; k < j; ++k) rest -= lower_[i][k] * lower_[j][k];
            if (j < i)
                lower_[i][j] = rest / lower_[j][j];
            else if (!(rest > kLeastPivot))
                return false;
            else
                lower_[i][i] = std::sqrt(rest);
        }
    return true;
}

template <int Degree>
void NestedDisc<Degree>::invert_factor() {
    for (std::size_t i = 0; i < kAll; ++i) {
        const double pivot = 1 / lower_[i][i];
        std::array<double, kAll> row{};
        for (std::size_t k = 0; k < i; ++k)
            for (std::size_t j = 0; j <= k; ++j) row[j] -= lower_[i][k] * inverse_[k][j];
        for (std::size_t j = 0; j < i; ++j) inverse_[i][j] = row[j] * pivot;
        inverse_[i][i] = pivot;
    }
}

template <int Degree>
template <std::size_t K>
auto NestedDisc<Degree>::coefficients() const -> std::array<double, K> {
    std::array<double, K> a{};
    for (std::size_t i = 0; i < K; ++i)
        for (std::size_t k = 0; k <= i; ++k) a[k] += inverse_[i][k] * y_[i];
    for (std::size_t k = 0; k < K; ++k) a[k] *= scale_[k];
    return a;
}

template <int Degree>
auto NestedDisc<Degree>::core_variance() const -> Variance {
    // A^-1 is the sum of the products of rows of the inverse factor.
    Variance out{0, 0};
    for (std::size_t i = 0; i < kAll; ++i) {
        std::array<double, kAll> row{};
        for (std::size_t k = 0; k <= i; ++k) row[k] = inverse_[i][k] * scale_[k];
        out.all += sq_even(row);
        if (i < kOwn) out.own = out.all;
    }
    return out;
}

template <int Degree>
auto NestedDisc<Degree>::slope_variance() const -> Variance {
    Variance out{0, 0};
    for (std::size_t i = 1; i < kAll; ++i) {
        for (std::size_t k = 1; k < 3 && k <= i; ++k) {
            const double slope = inverse_[i][k] * scale_[k];
            out.all += slope * slope;
        }
        if (i < kOwn) out.own = out.all;
    }
    return out;
}

template <int Degree>
double NestedDisc<Degree>::sq_explained() const {
    double sum = 0;
    for (const double y : y_) sum += y * y;
    return sum;
}

template <int Degree>
double NestedDisc<Degree>::sq_even(const std::array<double, kAll>& a) {
    const Tables& t = tables();
    std::array<double, Tables::kEven> even;
    for (std::size_t i = 0; i < Tables::kEven; ++i) even[i] = a[t.even[i]];
    double sum = 0;
    for (std::size_t i = 0; i < Tables::kEven; ++i) {
        double row = 0;
        for (std::size_t j = 0; j < Tables::kEven; ++j) row += t.core[i][j] * even[j];
        sum += even[i] * row;
    }
    return sum;
}

template <int Degree>
double NestedDisc<Degree>::blend_mean(const std::array<double, kAll>& a) {
    const Tables& t = tables();
    return std::inner_product(a.begin(), a.end(), t.blended.begin(), 0.0);
}

template class NestedDisc<2>;
template class NestedDisc<4>;
template std::array<double, 6> NestedDisc<2>::coefficients<6>() const;
template std::array<double, 6> NestedDisc<4>::coefficients<6>() const;
template std::array<double, 15> NestedDisc<4>::coefficients<15>() const;

}  // namespace slim
