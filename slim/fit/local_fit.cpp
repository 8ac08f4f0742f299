#include "slim/fit/local_fit.h"

#include "slim/fit/moments.h"
#include "slim/fit/nested_cholesky.h"
#include "slim/fit/slope_system.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <type_traits>

namespace slim {
namespace {

constexpr double kLeastFreedom = 2;     // effective points beyond K: with fewer, eps is no estimate
constexpr double kLeastShare = 0.25;    // of 1 - K / n_eff: eps^2 grows fourfold at most
/// First, second and third order at their steepest, degree >= 1: beyond it the patch leaves its
/// ball. A parabola over a right-angled edge has 2.4 (notes/0008).
constexpr double kSteepest = 4;

/// RSS / sum G w^2 below which the difference of sums is rounding, not residual.
template <class T>
constexpr double kCancelled = std::is_same_v<T, float> ? 1e-4 : 1e-10;

/// RSS by a pass over the residuals, where the sums cancel (exact planes, exact quadrics).
template <class T>
double residual_pass(const BallPoints<T>& p, double shrink, const Frame<double>& f,
                     const Polynomial<double>& gather_scaled) {
    double rss = 0;
    for (std::size_t i = 0; i < p.n; ++i) {
        const Vec3d x = f.local_from_world(Vec3d{p.x[i], p.y[i], p.z[i]});
        const double r = x.z - gather_scaled.value(x.x, x.y);
        rss += fit_weight(p.weight, static_cast<double>(p.sq[i]) / (shrink * shrink)) * r * r;
    }
    return rss;
}

/// Coefficients from coordinates divided by the gather radius to coordinates divided by the fit's.
Polynomial<double> rescale(const std::array<double, kMaxCoefficients>& a, double shrink) {
    Polynomial<double> out;
    double factor = 1 / shrink;
    std::size_t k = 0;
    for (int d = 0; d <= kMaxDegree; ++d, factor *= shrink)
        for (int t = 0; t <= d; ++t, ++k) out.a[k] = a[k] * factor;
    return out;
}

/// The plane w = mean height, for fits that no polynomial follows.
template <int Degree>
LocalFit mean_plane(const Moments<Degree>& m, double shrink, double radius) {
    LocalFit fit;
    fit.fallback = Fallback::plane;
    const double weight = m.weight();
    if (!(weight > 0)) return fit;
    const double mean = m.height[0] / weight;
    fit.polynomial.a[0] = mean / shrink;
    const double rss = std::max(0.0, m.sq_height - mean * m.height[0]);
    fit.sq_error = radius * radius * rss / weight;
    return fit;
}

/// What a term of a degree takes off sum G w^2 by fitting noise alone, over sum G^2 / sum G and the
/// noise's variance: terms of higher degree live where G is small. Disc averages under G
/// (notes/0005).
constexpr double kNoiseOfTerm[] = {1, 0.5182, 0.3715, 0.3064, 0.2694};

/// Fills in what the next degree would find.
void look_ahead(const NestedCholesky& solver, double weight, double radius, LocalFit& fit) {
    const int next = fit.degree + 1;
    if (fit.degree < 1 || solver.rank_degree() < next) return;
    const double noise = fit.sq_error * kNoiseOfTerm[next] / fit.n_effective;
    fit.sq_missed = radius * radius * solver.sq_gain(next) / weight - noise * (next + 1);
    fit.sq_missed_error = noise * std::sqrt(2.0 * (next + 1));
}

/// How far eps^2 may rise when the normals take part: a seventh of the noise in all, or what three
/// standard errors of the coefficients amount to. Normals that the points contradict are not
/// followed.
double most_raised(int degree, double n_effective) {
    const double k = n_coefficients(degree);
    return 1 + std::max(0.02, (k + 3 * std::sqrt(2 * k)) / n_effective);
}

/// The fit to points and normals in place of the fit to points alone. A slope counts as often as
/// its variance goes into that of a height, both as this ball shows them: about the fit of the
/// degree itself, normals as good as the points' own slopes (any that are made of them) hardly
/// count.
template <int MomentDegree, class T>
void follow_normals(const Moments<MomentDegree>& m, const NestedCholesky& alone,
                    const BallPoints<T>& points, double shrink, const Frame<double>& frame,
                    LocalFit& fit) {
    const auto slopes = accumulate_slopes<MomentDegree>(points, frame, shrink, T(kLeastCos));
    if (!(slopes.weight > 0) || fit.degree < 1) return;
    const SlopeSystem<MomentDegree> system(m, slopes);
    const double freedom = std::max(1 - n_coefficients(fit.degree) / fit.n_effective, kLeastShare);
    double sq_height = alone.sq_residual(fit.degree) / m.weight() / freedom;
    double sq_slope = system.sq_slopes_off(alone.coefficients(fit.degree)) / (2 * slopes.weight);
    const double most = most_raised(fit.degree, fit.n_effective) * sq_height;
    for (int pass = 0; pass < 2; ++pass) {
        if (!(sq_slope > 0) || !(sq_height > 0)) return;
        const NestedCholesky both = system.solve(sq_height / sq_slope);
        if (both.rank_degree() < fit.degree) return;
        const auto a = both.coefficients(fit.degree);
        sq_height = system.sq_heights_off(a) / m.weight() / freedom;
        sq_slope = system.sq_slopes_off(a) / (2 * slopes.weight);
        if (sq_height > most) return;
        if (pass == 0) continue;
        const Polynomial<double> polynomial = rescale(a, shrink);
        if (too_steep(polynomial)) return;
        fit.polynomial = polynomial;
        fit.sq_error = points.radius * points.radius * sq_height;
        const int next = fit.degree + 1;
        if (MomentDegree < next || both.rank_degree() < next || alone.rank_degree() < next) return;
        const NestedCholesky slopes_too = system.solve(shrink * shrink);
        if (slopes_too.rank_degree() < next) return;
        const auto found = both.gain_in(alone, next);
        const double noise = fit.sq_error * kNoiseOfTerm[next] / fit.n_effective;
        fit.sq_missed =
            points.radius * points.radius * found.sq_gain / m.weight() - noise * found.n_errors;
        const auto fully = both.gain_in(slopes_too, next);
        fit.sq_missed_slope = points.radius * points.radius * fully.sq_gain / m.weight() -
                              noise * fully.n_errors - fit.sq_missed;
        fit.sq_missed_error = noise * fully.n_errors * std::sqrt(2.0 / (next + 1));
        const double sq_radius = points.radius * points.radius * shrink * shrink;
        fit.sq_slope_error = 2 * sq_slope - fit.sq_missed_slope / sq_radius;
    }
}

/// What one pass over a ball gives: sums, and one factor that serves every degree.
template <int MomentDegree>
struct BallSolution {
    Moments<MomentDegree> moments;
    NestedCholesky solver;
    std::size_t n;  // points within the fit's radius
};

template <int MomentDegree, class T>
BallSolution<MomentDegree> solve_ball(const BallPoints<T>& points, double shrink,
                                      const Frame<double>& frame) {
    const auto m = accumulate_moments<MomentDegree>(points, frame, shrink);
    using V = stdx::native_simd<T>;
    const V limit = static_cast<T>(shrink * shrink);
    std::size_t n = 0;  // padding is outside
    for (std::size_t i = 0; i < points.padded(); i += V::size())
        n += static_cast<std::size_t>(
            std::popcount(lane_bits(V(&points.sq[i], stdx::element_aligned) < limit)));
    return {m, NestedCholesky(MomentDegree, m.monomial, m.height, m.sq_height), n};
}

/// Whether n points, of which n_effective count under G, are enough for a degree.
bool are_enough(std::size_t n, double n_effective, int degree, Enough enough) {
    const int k = n_coefficients(degree);
    return n >= 2 * static_cast<std::size_t>(k) &&
           (enough == Enough::points || n_effective >= k + kLeastFreedom);
}

/// The fit of a degree, or what NUMERICS 2.4 leaves of it;
/// sums of a higher degree are for look_ahead.
template <int MomentDegree, class T>
LocalFit fit_of_degree(const BallSolution<MomentDegree>& solution, int degree,
                       const BallPoints<T>& points, double shrink, const Frame<double>& frame,
                       Enough enough = Enough::freedom) {
    const auto& [m, solver, n] = solution;
    const bool looks_ahead = MomentDegree > degree;
    LocalFit fit;
    Fallback cause = Fallback::none;
    const double n_eff = m.n_effective();
    while (degree > 1 && !are_enough(n, n_eff, degree, enough))
        --degree, cause = Fallback::few_points;
    if (solver.rank_degree() < degree) degree = solver.rank_degree(), cause = Fallback::rank;
    for (; degree >= 1; --degree, cause = Fallback::steep) {
        const auto a = solver.coefficients(degree);
        fit.polynomial = rescale(a, shrink);
        if (too_steep(fit.polynomial)) continue;
        double rss = solver.sq_residual(degree);
        if (rss < kCancelled<T> * m.sq_height)
            rss = residual_pass(points, shrink, frame, Polynomial<double>{a});
        const double freedom = 1 - n_coefficients(degree) / n_eff;
        fit.degree = degree;
        fit.sq_error =
            points.radius * points.radius * rss / m.weight() / std::max(freedom, kLeastShare);
        break;
    }
    if (degree < 1) fit = mean_plane(m, shrink, points.radius), cause = Fallback::plane;
    fit.fallback = cause;
    fit.n_effective = n_eff;
    fit.n_points = n;
    if (looks_ahead) look_ahead(solver, m.weight(), points.radius, fit);
    if (points.normals_count) follow_normals(m, solver, points, shrink, frame, fit);
    return fit;
}

template <int Degree, int MomentDegree, class T>
LocalFit fit_degree(const BallPoints<T>& points, double shrink, const Frame<double>& frame,
                    Enough enough = Enough::freedom) {
    return fit_of_degree(solve_ball<MomentDegree>(points, shrink, frame), Degree, points, shrink,
                         frame, enough);
}

template <int Degree, class T>
SpreadFit fit_degree_with_spread(const BallPoints<T>& points, double shrink,
                                 const Frame<double>& frame) {
    const auto solution = solve_ball<Degree>(points, shrink, frame);
    SpreadFit out{fit_of_degree(solution, Degree, points, shrink, frame), {}};
    if (out.fit.degree >= 1)
        out.spread = spread_of(solution.moments, solution.solver, out.fit.degree);
    return out;
}

}  // namespace

bool too_steep(const Polynomial<double>& p) {
    const auto& a = p.a;
    // What overflows here is too steep as well.
    const auto size = [](double x, double y) { return std::sqrt(x * x + y * y); };
    const double first = size(a[1], a[2]);
    const double second = std::abs(a[3] + a[5]) / 2 + size(a[3] - a[5], a[4]) / 2;
    const double third = size(3 * a[6] + a[8], a[7] + 3 * a[9]) / 4 +
                         size(a[6] - a[8], a[7] - a[9]) / 4;
    return !(first + second + third <= kSteepest);
}

const char* fallback_name(Fallback fallback) {
    constexpr const char* names[kFallbacks] = {"none", "few_points", "rank",
                                                 "steep", "plane", "lower_explains"};
    return names[static_cast<std::size_t>(fallback)];
}

template <class T>
std::size_t count_off_sheet(const BallPoints<T>& p, std::span<const SetAside<T>> aside,
                            const Frame<double>& frame, const LocalFit& fit, double tolerance) {
    tolerance /= p.radius;
    std::size_t count = 0;
    for (const SetAside<T>& a : aside) {
        const Vec3d x = frame.local_from_world(Vec3d{p.x[a.index], p.y[a.index], p.z[a.index]});
        count += std::abs(x.z - fit.polynomial.value(x.x, x.y)) > tolerance;
    }
    return count;
}

template <class T>
LocalFit fit_ball(const BallPoints<T>& points, double shrink, const Frame<double>& frame,
                  int degree, Enough enough) {
    if (degree <= 1) return fit_degree<1, 1>(points, shrink, frame);
    if (degree == 2) return fit_degree<2, 2>(points, shrink, frame, enough);
    return fit_degree<3, 3>(points, shrink, frame, enough);
}

template <class T>
LocalFit fit_ball_ahead(const BallPoints<T>& points, double shrink, const Frame<double>& frame,
                        int degree) {
    if (degree <= 1) return fit_degree<1, 2>(points, shrink, frame);
    if (degree == 2) return fit_degree<2, 3>(points, shrink, frame);
    return fit_degree<3, 4>(points, shrink, frame);
}

template <class T>
SpreadFit fit_ball_with_spread(const BallPoints<T>& points, double shrink,
                               const Frame<double>& frame, int degree) {
    return degree <= 2 ? fit_degree_with_spread<2>(points, shrink, frame)
                       : fit_degree_with_spread<3>(points, shrink, frame);
}

template <class T>
std::array<LocalFit, kMaxDegree> fit_every_degree(const BallPoints<T>& points, double shrink,
                                                  const Frame<double>& frame) {
    const auto solution = solve_ball<kMaxDegree + 1>(points, shrink, frame);
    std::array<LocalFit, kMaxDegree> fits;
    for (int d = 1; d <= kMaxDegree; ++d)
        fits[static_cast<std::size_t>(d - 1)] = fit_of_degree(solution, d, points, shrink, frame);
    return fits;
}

template std::size_t count_off_sheet(const BallPoints<float>&, std::span<const SetAside<float>>,
                                     const Frame<double>&, const LocalFit&, double);
template std::size_t count_off_sheet(const BallPoints<double>&, std::span<const SetAside<double>>,
                                     const Frame<double>&, const LocalFit&, double);
template LocalFit fit_ball(const BallPoints<float>&, double, const Frame<double>&, int, Enough);
template LocalFit fit_ball(const BallPoints<double>&, double, const Frame<double>&, int, Enough);
template std::array<LocalFit, kMaxDegree> fit_every_degree(const BallPoints<float>&, double,
                                                           const Frame<double>&);
template std::array<LocalFit, kMaxDegree> fit_every_degree(const BallPoints<double>&, double,
                                                           const Frame<double>&);
template SpreadFit fit_ball_with_spread(const BallPoints<float>&, double, const Frame<double>&,
                                        int);
template LocalFit fit_ball_ahead(const BallPoints<float>&, double, const Frame<double>&, int);

}  // namespace slim
