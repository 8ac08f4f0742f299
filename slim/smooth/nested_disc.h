#pragma once

#include "slim/fit/moments.h"
#include "slim/smooth/wide_fit.h"

#include <array>
#include <cstddef>
#include <optional>

namespace slim {

/// Least squares of a polynomial over a disc and of the quadratic in it, from equally weighted
/// sums: one factor serves both, the leading block being that of the quadratic (NUMERICS 2.2). The
/// system is scaled to unit diagonal. Beside NestedCholesky (slim/fit), which gives the diagonal of
/// the inverse alone: the mean over the core asks for all of it.
template <int Degree>
class NestedDisc {
public:
    static constexpr std::size_t kAll = Moments<Degree>::kBasis, kOwn = n_coefficients(2);

    /// Nothing if a squared pivot is below 1e-6.
    static std::optional<NestedDisc> solve(const Moments<Degree>& m);

    /// Coefficients of the first K terms fitted alone, K = kOwn or kAll.
    template <std::size_t K>
    std::array<double, K> coefficients() const;
    /// Of the fit of kOwn terms, and of all.
    struct Variance {
        double own, all;
    };
    /// Variance of the height by unit noise, mean over the core, of even terms.
    Variance core_variance() const;
    /// Variance of both slopes in the middle by unit noise, their sum.
    Variance slope_variance() const;
    /// What the sum of squared heights is made less by.
    double sq_explained() const;
    /// Mean over the core of the square of a polynomial's even terms.
    static double sq_even(const std::array<double, kAll>& a);
    /// Mean of a polynomial under the weight that fits are blended with,
    /// over a disc of twice the core.
    static double blend_mean(const std::array<double, kAll>& a);

private:
    struct Tables;
    static const Tables& tables();
    using Square = std::array<std::array<double, kAll>, kAll>;
    bool factorise(const Moments<Degree>& m);
    void invert_factor();

    Square lower_, inverse_;              // L and its inverse, the lower halves
    std::array<double, kAll> scale_, y_;  // y = L^-1 scaled heights
};

extern template class NestedDisc<2>;
extern template class NestedDisc<4>;

}  // namespace slim
