#include "slim/smooth/wide_fit.h"

#include "slim/fit/moments.h"
#include "slim/smooth/nested_disc.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace slim {
namespace {

constexpr double kOff = 0.25;
constexpr double kThickness = 6;
constexpr double kLeastPoints = 60;
constexpr double kLeastOfQuadratic = 18;
constexpr float kSqInner = 0.25f;    ///< squared, of the disc's radius: no fit
                                     ///< without a point so near the middle
constexpr double kCancelled = 1e-4;  ///< of the sum of squares: below it the
                                     ///< difference of sums is rounding
constexpr double kRounding = 6e-8;   ///< of a coordinate over the radius, a float

bool has_inner_point(const BallPoints<float>& ball) {
    return std::any_of(ball.sq.begin(), ball.sq.begin() + static_cast<std::ptrdiff_t>(ball.n),
                       [](float sq) { return sq < kSqInner; });
}

/// Sum of squares by a pass over the residuals, coordinates over the radius.
template <std::size_t K>
double residual_pass(const BallPoints<float>& ball, const Frame<double>& frame,
                     const std::array<double, K>& a) {
    double sum = 0;
    for (std::size_t i = 0; i < ball.n; ++i) {
        const Vec3d x = frame.local_from_world(Vec3d{ball.x[i], ball.y[i], ball.z[i]});
        std::array<double, K> phi;
        phi[0] = 1;
        for (std::size_t d = 1, at = 1, below = 0; at < K; below += d, ++d) {
            for (std::size_t t = 0; t < d; ++t) phi[at++] = phi[below + t] * x.x;
            phi[at] = phi[at - d - 1] * x.y;
            ++at;
        }
        const double off = x.z - std::inner_product(a.begin(), a.end(), phi.begin(), 0.0);
        sum += off * off;
    }
    return sum;
}

template <int Degree>
std::optional<WideFit> fit_gathered(const WideWork& work, const Frame<double>& frame) {
    using Disc = NestedDisc<Degree>;
    constexpr std::size_t kAll = Disc::kAll, kOwn = Disc::kOwn;
    const auto n = static_cast<double>(work.ball.n);
    if (!(n >= (Degree > 2 ? kLeastPoints : kLeastOfQuadratic)) || !has_inner_point(work.ball))
        return std::nullopt;
    const auto m = accumulate_moments<Degree>(work.ball, frame, 1);
    const auto disc = Disc::solve(m);
    if (!disc) return std::nullopt;
    const std::array<double, kOwn> own = disc->template coefficients<kOwn>();
    std::array<double, kAll> all = disc->template coefficients<kAll>();
    const double sq = work.ball.radius * work.ball.radius;
    WideFit fit;
    std::copy(own.begin(), own.end(), fit.polynomial.a.begin());
    fit.n = n;
    double residual = m.sq_height - disc->sq_explained();
    if (!(residual >= kCancelled * m.sq_height))
        residual = residual_pass<kAll>(work.ball, frame, all);
    fit.sq_rounding = sq * kRounding * kRounding;
    fit.sq_noise = std::max(sq * residual / (n - static_cast<double>(kAll)), fit.sq_rounding);
    const auto [spread, spread_of_all] = disc->core_variance();
    fit.spread = spread * n;
    fit.sq_error = fit.sq_noise * spread;
    if (Degree == 2) return fit;
    for (std::size_t i = 0; i < kOwn; ++i) all[i] -= own[i];
    const double by_noise = fit.sq_noise * std::max(0.0, spread_of_all - spread);
    fit.sq_bias = sq * Disc::sq_even(all) - by_noise;
    fit.sq_bias_error = by_noise * std::sqrt(2.0);
    fit.lift = work.ball.radius * Disc::blend_mean(all);
    fit.sq_lift_error = by_noise;
    fit.turn = {all[1], all[2]};
    const auto slopes = disc->slope_variance();
    fit.sq_turn_error = fit.sq_noise / sq * (slopes.all - slopes.own);
    return fit;
}

}  // namespace

double largest_curvature(const Polynomial<double>& p, double radius) {
    const auto& a = p.a;
    return (std::abs(a[3] + a[5]) + std::hypot(a[3] - a[5], a[4])) / radius;
}

double WideFit::sq_stretch() const {
    const auto& a = polynomial.a;
    return 1 + a[1] * a[1] + a[2] * a[2] + a[3] * a[3] + a[5] * a[5] + a[4] * a[4] / 2;
}

std::optional<WideFit> fit_wide(const PointTree& points, const WideDisc& disc, bool ahead,
                                WideWork& work) {
    work.ball.weight = FitWeight::uniform;
    const double r = disc.radius, sag = std::min(r, disc.curvature * r * r / 2);
    const double reach = std::hypot(r, kThickness * disc.noise + sag);
    gather_disc(points, disc.center, disc.frame.normal, r, reach, kLeastCos, work.ball);
    return ahead ? fit_gathered<4>(work, disc.frame) : fit_gathered<2>(work, disc.frame);
}

bool put_on(const WideFit& fit, WideDisc& disc) {
    const auto& a = fit.polynomial.a;
    if (!(std::abs(a[0]) * disc.radius > kOff * disc.noise)) return false;
    disc.center += disc.frame.normal * (a[0] * disc.radius);
    disc.frame = frame_from_normal(normalized(disc.frame.world_from_local({-a[1], -a[2], 1})));
    return true;
}

}  // namespace slim
