#include "slim/fit/sheet_by_normals.h"

#include "slim/fit/nested_cholesky.h"
#include "slim/fit/slope_system.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr int kDegree = 2;
/// Variance of a height, over rho^2, over that of a slope: heights rule, slopes say the curvature
/// that they leave open.
constexpr double kHeightOverSlope = 0.02;
constexpr double kLeastFreedom = 2;   // effective heights and slopes beyond K, as in LocalFit
constexpr double kLeastShare = 0.25;  // of 1 - K / n_eff, too

}  // namespace

template <class T>
std::optional<LocalFit> fit_by_normals(const BallPoints<T>& points, const Frame<double>& frame) {
    constexpr int k = n_coefficients(kDegree);
    const auto heights = accumulate_moments<kDegree>(points, frame, 1);
    const auto slopes = accumulate_slopes<kDegree>(points, frame, 1, T(kLeastCos));
    if (points.n < static_cast<std::size_t>(k) || !(heights.weight() > 0)) return {};
    const double n_effective = heights.n_effective() * (1 + 2 * slopes.weight / heights.weight());
    if (n_effective < k + kLeastFreedom) return {};
    const SlopeSystem<kDegree> system(heights, slopes);
    const NestedCholesky solver = system.solve(kHeightOverSlope);
    if (solver.rank_degree() < kDegree) return {};
    LocalFit fit;
    fit.polynomial.a = solver.coefficients(kDegree);
    if (too_steep(fit.polynomial)) return {};
    fit.degree = kDegree;
    fit.n_effective = heights.n_effective();
    fit.n_points = points.n;
    const double freedom = std::max(1 - k / n_effective, kLeastShare);
    fit.sq_error = points.radius * points.radius * system.sq_heights_off(fit.polynomial.a) /
                   heights.weight() / freedom;
    return fit;
}

template std::optional<LocalFit> fit_by_normals(const BallPoints<float>&, const Frame<double>&);
template std::optional<LocalFit> fit_by_normals(const BallPoints<double>&, const Frame<double>&);

}  // namespace slim
