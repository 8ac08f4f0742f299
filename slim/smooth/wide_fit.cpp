#include "slim/smooth/wide_fit.h"

#include "slim/base/simd.h"
#include "slim/fit/moments.h"
#include "slim/smooth/nested_disc.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <vector>

namespace slim {
namespace {

constexpr double kOff = 0.25;
constexpr double kThickness = 6;
constexpr double kLeastPoints = 60;
constexpr double kLeastOfQuadratic = 18;
constexpr float kSqInner = 0.25f;    ///< squared, of the disc's radius: no fit without a point so near the middle
constexpr double kCancelled = 1e-4;  ///< of the sum of squares: below it the difference of sums is rounding
constexpr double kRounding = 6e-8;   ///< of a coordinate over the radius, a float

bool has_inner_point(const BallPoints<float>& ball) {
    return std::any_of(ball.sq.begin(), ball.sq.begin() + static_cast<std::ptrdiff_t>(ball.n),
                       [](float sq) { return sq < kSqInner; });
}

/// Sum of squares by a pass over the residuals, coordinates over the radius.
template <std::size_t K>
double residual_pass(const BallPoints<float>& ball, const Frame<double>& frame, const std::array<double, K>& a) {
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
    if (!(n >= (Degree > 2 ? kLeastPoints : kLeastOfQuadratic)) || !has_inner_point(work.ball)) return std::nullopt;
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
    if (!(residual >= kCancelled * m.sq_height)) residual = residual_pass<kAll>(work.ball, frame, all);
    fit.sq_rounding = sq * kRounding * kRounding;
    fit.sq_noise = std::max(sq * residual / (n - static_cast<double>(kAll)), fit.sq_rounding);
    const double spread = disc->template core_variance<kOwn>();
    fit.spread = spread * n;
    fit.sq_error = fit.sq_noise * spread;
    if (Degree == 2) return fit;
    for (std::size_t i = 0; i < kOwn; ++i) all[i] -= own[i];
    const double by_noise = fit.sq_noise * std::max(0.0, disc->template core_variance<kAll>() - spread);
    fit.sq_bias = sq * Disc::sq_even(all) - by_noise;
    fit.sq_bias_error = by_noise * std::sqrt(2.0);
    return fit;
}

/// Leaves of a ball the points whose feet in the frame's plane are nearer than `radius`, with their distances there instead
/// of those in space, coordinates over `radius`; those whose normals are below kLeastCos to the frame's do not count.
[[gnu::flatten]] void stand_up(const Frame<double>& frame, double radius, BallPoints<float>& ball) {
    const auto scale = static_cast<float>(ball.radius / radius);
    const Vec3f n = to_float(frame.normal);
    const std::size_t end = ball.padded();
    ball.n = 0;
    for (std::size_t i = 0; i < end; i += FloatV::size()) {
        const auto lanes = [i](const std::vector<float>& a) { return FloatV(&a[i], stdx::element_aligned); };
        const FloatV x = lanes(ball.x) * scale, y = lanes(ball.y) * scale, z = lanes(ball.z) * scale;
        const FloatV w = n.x * x + n.y * y + n.z * z;
        const FloatV sq = stdx::max(x * x + y * y + z * z - w * w, FloatV(0.0f));
        const FloatV nx = lanes(ball.nx), ny = lanes(ball.ny), nz = lanes(ball.nz);
        const auto measured = nx != 0.0f || ny != 0.0f || nz != 0.0f;
        const auto contrary = measured && n.x * nx + n.y * ny + n.z * nz < kLeastCos;
        const std::uint64_t counts = lane_bits(lanes(ball.sq) < 1.0f && sq < 1.0f && !contrary);
        if (counts == 0) continue;
        const auto put = [&](const FloatV& v, std::vector<float>& a) { compress_to(v, counts, &a[ball.n]); };
        put(x, ball.x), put(y, ball.y), put(z, ball.z), put(sq, ball.sq);
        put(nx, ball.nx), put(ny, ball.ny), put(nz, ball.nz);
        ball.n += static_cast<std::size_t>(std::popcount(counts));
    }
    ball.radius = radius;
    // Gathering left room for a group more than there were.
    const auto pad = [&](float v, std::vector<float>& a) { FloatV(v).copy_to(&a[ball.n], stdx::element_aligned); };
    pad(0, ball.x), pad(0, ball.y), pad(0, ball.z), pad(2, ball.sq);
}

}  // namespace

std::optional<WideFit> fit_wide(const PointTree& points, const Vec3d& center, const Frame<double>& frame,
                                double radius, double noise, bool ahead, WideWork& work) {
    work.ball.weight = FitWeight::uniform;
    gather_ball(points, center, std::hypot(radius, kThickness * noise), work.ball);
    stand_up(frame, radius, work.ball);
    return ahead ? fit_gathered<4>(work, frame) : fit_gathered<2>(work, frame);
}

bool put_on(const WideFit& fit, double radius, double noise, Vec3d& place, Frame<double>& frame) {
    const auto& a = fit.polynomial.a;
    if (!(std::abs(a[0]) * radius > kOff * noise)) return false;
    place += frame.normal * (a[0] * radius);
    frame = frame_from_normal(normalized(frame.world_from_local({-a[1], -a[2], 1})));
    return true;
}

}  // namespace slim
