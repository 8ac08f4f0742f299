#include "slim/fit/steady_curvature.h"

#include "slim/fit/moments.h"
#include "slim/fit/nested_cholesky.h"
#include "slim/model/surfel.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace slim {
namespace {

constexpr int kWiderBalls = 2;         // g^-1, g^-2; with a third 0.62, not 0.65 % of bunny_raw
constexpr double kMostWorse = 1.5;     // eps^2 of a plane with lent curvature over its own
constexpr double kSqErrors = 4;        // two standard errors, squared
constexpr std::size_t kSample = 512;   // points of a wider ball

using Coefficients = std::array<double, kMaxCoefficients>;

constexpr std::size_t first_of(int order) {
    return static_cast<std::size_t>(order * (order + 1) / 2);
}

/// |sum c_t u^(d-t) v^t|^2 = sum c_t^2 / binomial(d, t) does not change when (u, v) is turned.
double inverse_binomial(int order, int t) {
    constexpr double table[4][4] = {{1}, {1, 1}, {1, 0.5, 1}, {1, 1. / 3, 1. / 3, 1}};
    return table[order][t];
}

/// Coefficients measured in one ball, in units of the narrow one, and their variance by order.
struct Scale {
    int degree = 0;
    Coefficients a{};
    std::array<double, kMaxDegree + 1> variance{};
};

/// The terms of second order and above of a fit of radius `shrink` times the ball's, in units of
/// the narrow one, which is `ratio` times smaller than the ball; `noise`: variance of the heights,
/// in the ball's radius.
Scale in_narrow_units(const SpreadFit& measured, double shrink, double ratio, double noise) {
    Scale s;
    if (measured.fit.degree < 2) return s;
    s.degree = measured.fit.degree;
    for (int order = 2; order <= s.degree; ++order) {
        double sum = 0;
        for (int t = 0; t <= order; ++t) {
            const std::size_t k = first_of(order) + static_cast<std::size_t>(t);
            s.a[k] = measured.fit.polynomial.a[k] * std::pow(shrink * ratio, 1 - order);
            sum += measured.spread[k] * inverse_binomial(order, t);
        }
        s.variance[static_cast<std::size_t>(order)] = sum * noise * std::pow(ratio, 2 - 2 * order);
    }
    return s;
}

/// Variance of the heights that a fit shows, coordinates divided by a radius.
double noise_of(const LocalFit& fit, double noise_variance, double radius) {
    return std::min(fit.sq_error, noise_variance) / (radius * radius);
}

/// Moves `q` towards a finer measurement as far as that stands out of its noise.
void take_over(const Scale& finer, Scale& q) {
    for (int order = 2; order <= finer.degree; ++order) {
        const std::size_t first = first_of(order), n = static_cast<std::size_t>(order) + 1;
        double sq = 0;
        for (std::size_t t = 0; t < n; ++t) {
            const double d = finer.a[first + t] - q.a[first + t];
            sq += d * d * inverse_binomial(order, static_cast<int>(t));
        }
        if (!(sq > 0)) continue;
        const double keep =
            std::max(0.0, 1 - kSqErrors * finer.variance[static_cast<std::size_t>(order)] / sq);
        for (std::size_t k = first; k < first + n; ++k) q.a[k] += keep * (finer.a[k] - q.a[k]);
    }
    q.degree = std::max(q.degree, finer.degree);
}

/// The plane that fits best once the terms of higher order are given.
template <int Degree>
LocalFit refit_plane(const NarrowFit& narrow, const Moments<Degree>& m, const Scale& q) {
    std::array<double, Moments<Degree>::kBasis> height = m.height;
    double sq_height = m.sq_height;
    for (std::size_t k = 3; k < height.size(); ++k) {
        const double before = height[k];
        for (std::size_t i = 0; i < height.size(); ++i)
            height[i] -= m.monomial[product_index(i, k)] * q.a[k];
        sq_height -= q.a[k] * (before + height[k]);
    }
    LocalFit out = narrow.fit;
    const NestedCholesky solver(1, m.monomial, height, sq_height);
    if (solver.rank_degree() < 1) return out;
    out.polynomial.a = q.a;
    const Coefficients plane = solver.coefficients(1);
    std::copy_n(plane.begin(), 3, out.polynomial.a.begin());
    if (too_steep(out.polynomial)) return narrow.fit;
    const double freedom = 1 - n_coefficients(1) / std::max(m.n_effective(), 4.0);
    const double sq_error =
        narrow.ball.radius * narrow.ball.radius * solver.sq_residual(1) / m.weight() / freedom;
    // Beside an edge the wider balls' curvature is the edge's:
    // a plane that explains its points stays.
    if (narrow.fit.degree < 2 && sq_error > kMostWorse * narrow.fit.sq_error) return narrow.fit;
    // The terms of higher order that were fitted here are estimates no more than the plane is.
    out.sq_error = narrow.fit.degree >= 2 ? std::max(sq_error, narrow.fit.sq_error) : sq_error;
    out.degree = q.degree;
    return out;
}

/// The finest thinning that leaves a wider ball about kSample points,
/// judged by those of the narrow one.
std::size_t thinning_for(const PointPyramid& points, std::size_t n_narrow, double ratio) {
    double n = static_cast<double>(n_narrow) * ratio * ratio;
    std::size_t level = 0;
    for (; n > kSample && level + 1 < points.n_levels(); ++level) n *= kGoldenRatio * kGoldenRatio;
    return level;
}

/// What the wider balls say, coarse to fine. Floats will do:
/// of their terms less than their noise is lost.
Scale wider_scales(const PointPyramid& points, const NarrowFit& narrow, int degree,
                   double noise_variance, BallPoints<float>& work) {
    const double ratio = std::pow(kGoldenRatio, -kWiderBalls);
    work.weight = narrow.ball.weight;
    gather_ball(points.level(thinning_for(points, narrow.ball.n, ratio)), narrow.center,
                narrow.ball.radius * ratio, work);
    std::vector<SetAside<float>> aside;
    set_contrary_aside(work, narrow.frame.normal, aside);
    Scale q;
    double shrink = 1;
    for (int wider = kWiderBalls; wider > 0; --wider, shrink *= kGoldenRatio) {
        const SpreadFit found = fit_ball_with_spread(work, shrink, narrow.frame, degree);
        const double noise = noise_of(found.fit, noise_variance, work.radius);
        take_over(in_narrow_units(found, shrink, ratio, noise), q);
    }
    return q;
}

template <int Degree>
LocalFit steady(const PointPyramid& points, const NarrowFit& narrow, double noise_variance,
                BallPoints<float>& work) {
    Scale q = wider_scales(points, narrow, Degree, noise_variance, work);
    if (q.degree < 2) return narrow.fit;
    const auto moments = accumulate_moments<Degree>(narrow.ball, narrow.frame, 1);
    if (narrow.fit.degree >= 2) {
        const NestedCholesky solver(Degree, moments.monomial, moments.height, moments.sq_height);
        const SpreadFit own{narrow.fit, spread_of(moments, solver, narrow.fit.degree)};
        take_over(in_narrow_units(own, 1, 1, noise_of(own.fit, noise_variance, narrow.ball.radius)),
                  q);
    }
    return refit_plane<Degree>(narrow, moments, q);
}

}  // namespace

LocalFit steady_curvature(const PointPyramid& points, const NarrowFit& narrow, int degree,
                          double noise_variance, BallPoints<float>& work) {
    if (degree == 2) return steady<2>(points, narrow, noise_variance, work);
    if (degree == 3) return steady<3>(points, narrow, noise_variance, work);
    return narrow.fit;
}

}  // namespace slim
