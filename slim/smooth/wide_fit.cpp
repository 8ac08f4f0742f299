#include "slim/smooth/wide_fit.h"

#include "slim/base/simd.h"
#include "slim/fit/moments.h"
#include "slim/fit/nested_cholesky.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace slim {
namespace {

constexpr double kLeastPivot = 1e-6;
constexpr double kOff = 0.25;
constexpr double kThickness = 6;
constexpr double kLeastPoints = 60;
constexpr double kLeastOfQuadratic = 18;
constexpr float kSqInner = 0.25f;    ///< squared, of the disc's radius: no fit without a point so near the middle
constexpr double kCancelled = 1e-4;  ///< of the sum of squares: below it the difference of sums is rounding
constexpr double kRounding = 6e-8;   ///< of a coordinate over the radius, a float

template <int K>
using Square = Eigen::Matrix<double, K, K>;
template <int K>
using Column = Eigen::Matrix<double, K, 1>;

/// Mean of u^a v^b over the disc of radius kCore.
double core_mean(int a, int b) {
    if (a % 2 != 0 || b % 2 != 0) return 0;
    double mean = std::pow(kCore, a + b) * 2 / (a + b + 2);
    for (int i = a - 1; i > 0; i -= 2) mean *= i;
    for (int i = b - 1; i > 0; i -= 2) mean *= i;
    for (int i = a + b; i > 0; i -= 2) mean /= i;
    return mean;
}

/// Mean over the core of phi phi^T, of terms of even degree.
template <int K>
const Square<K>& even_core() {
    static const Square<K> mean = [] {
        std::vector<std::pair<int, int>> power;
        for (int d = 0; static_cast<int>(power.size()) < K; ++d)
            for (int b = 0; b <= d; ++b) power.emplace_back(d - b, b);
        Square<K> m = Square<K>::Zero();
        for (int i = 0; i < K; ++i)
            for (int j = 0; j < K; ++j) {
                const auto [ai, bi] = power[static_cast<std::size_t>(i)];
                const auto [aj, bj] = power[static_cast<std::size_t>(j)];
                if ((ai + bi) % 2 == 0 && (aj + bj) % 2 == 0) m(i, j) = core_mean(ai + aj, bi + bj);
            }
        return m;
    }();
    return mean;
}

/// Coefficients and the inverse of A.
template <int K>
struct Solution {
    Column<K> a;
    Square<K> inverse;
};

template <int K, int Degree>
std::optional<Solution<K>> solve(const Moments<Degree>& m) {
    Square<K> matrix;
    Column<K> height, scale;
    for (int i = 0; i < K; ++i) {
        const auto row = static_cast<std::size_t>(i);
        height(i) = m.height[row];
        for (int j = 0; j < K; ++j) matrix(i, j) = m.monomial[product_index(row, static_cast<std::size_t>(j))];
        if (!(matrix(i, i) > 0)) return std::nullopt;
        scale(i) = 1 / std::sqrt(matrix(i, i));
    }
    const Eigen::LLT<Square<K>> factor(scale.asDiagonal() * matrix * scale.asDiagonal());
    if (factor.info() != Eigen::Success) return std::nullopt;
    const Square<K> lower = factor.matrixL();
    if (!(lower.diagonal().cwiseAbs2().minCoeff() > kLeastPivot)) return std::nullopt;
    Solution<K> out;
    out.a = scale.asDiagonal() * factor.solve(scale.asDiagonal() * height);
    out.inverse = scale.asDiagonal() * factor.solve(Square<K>(scale.asDiagonal()));
    return out;
}

template <int K>
double core_variance(const Square<K>& inverse) {
    return (even_core<K>().cwiseProduct(inverse)).sum();
}

bool has_inner_point(const BallPoints<float>& ball) {
    return std::any_of(ball.sq.begin(), ball.sq.begin() + static_cast<std::ptrdiff_t>(ball.n),
                       [](float sq) { return sq < kSqInner; });
}

/// Sum of squares by a pass over the residuals, coordinates over the radius.
template <int K>
double residual_pass(const BallPoints<float>& ball, const Frame<double>& frame, const Column<K>& a) {
    double sum = 0;
    for (std::size_t i = 0; i < ball.n; ++i) {
        if (!(ball.sq[i] < 1)) continue;
        const Vec3d x = frame.local_from_world(Vec3d{ball.x[i], ball.y[i], ball.z[i]});
        Column<K> phi;
        phi(0) = 1;
        for (int d = 1, at = 1, below = 0; at < K; below += d, ++d) {
            for (int t = 0; t < d; ++t) phi(at++) = phi(below + t) * x.x;
            phi(at) = phi(at - d - 1) * x.y;
            ++at;
        }
        sum += std::pow(x.z - a.dot(phi), 2);
    }
    return sum;
}

template <int Degree>
std::optional<WideFit> fit_gathered(const WideWork& work, const Frame<double>& frame) {
    constexpr int kAll = Moments<Degree>::kBasis, kOwn = n_coefficients(2);
    const auto m = accumulate_moments<Degree>(work.ball, frame, 1);
    const double n = m.weight();
    if (!(n >= (Degree > 2 ? kLeastPoints : kLeastOfQuadratic)) || !has_inner_point(work.ball)) return std::nullopt;
    const auto own = solve<kOwn>(m);
    const auto all = solve<kAll>(m);
    if (!own || !all) return std::nullopt;
    Column<kAll> height;
    for (int i = 0; i < kAll; ++i) height(i) = m.height[static_cast<std::size_t>(i)];
    const double sq = work.ball.radius * work.ball.radius;
    WideFit fit;
    for (int i = 0; i < kOwn; ++i) fit.polynomial.a[static_cast<std::size_t>(i)] = own->a(i);
    fit.n = n;
    double residual = m.sq_height - height.dot(all->a);
    if (!(residual >= kCancelled * m.sq_height)) residual = residual_pass<kAll>(work.ball, frame, all->a);
    fit.sq_rounding = sq * kRounding * kRounding;
    fit.sq_noise = std::max(sq * residual / (n - kAll), fit.sq_rounding);
    const double spread = core_variance<kOwn>(own->inverse);
    fit.spread = spread * n;
    fit.sq_error = fit.sq_noise * spread;
    if (Degree == 2) return fit;
    Column<kAll> off = all->a;
    off.template head<kOwn>() -= own->a;
    const double by_noise = fit.sq_noise * std::max(0.0, core_variance<kAll>(all->inverse) - spread);
    fit.sq_bias = sq * off.dot(even_core<kAll>() * off) - by_noise;
    fit.sq_bias_error = by_noise * std::sqrt(2.0);
    return fit;
}

/// Distances in the frame's plane instead of those in space, coordinates over `radius`; points whose normals are below
/// kLeastCos to the frame's do not count.
[[gnu::flatten]] void stand_up(const Frame<double>& frame, double radius, BallPoints<float>& ball) {
    const auto scale = static_cast<float>(ball.radius / radius);
    const Vec3f n = to_float(frame.normal);
    for (std::size_t i = 0; i < ball.padded(); i += FloatV::size()) {
        const auto lanes = [i](const std::vector<float>& a) { return FloatV(&a[i], stdx::element_aligned); };
        const FloatV x = lanes(ball.x) * scale, y = lanes(ball.y) * scale, z = lanes(ball.z) * scale;
        const FloatV w = n.x * x + n.y * y + n.z * z;
        const FloatV sq = x * x + y * y + z * z - w * w;
        const FloatV nx = lanes(ball.nx), ny = lanes(ball.ny), nz = lanes(ball.nz);
        const auto measured = nx != 0.0f || ny != 0.0f || nz != 0.0f;
        const auto contrary = measured && n.x * nx + n.y * ny + n.z * nz < kLeastCos;
        const auto counts = lanes(ball.sq) < 1.0f && !contrary;
        const auto put = [i](const FloatV& v, std::vector<float>& a) { v.copy_to(&a[i], stdx::element_aligned); };
        put(x, ball.x), put(y, ball.y), put(z, ball.z);
        put(select(counts, select(sq > 0.0f, sq, FloatV(0.0f)), FloatV(2.0f)), ball.sq);
    }
    ball.radius = radius;
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
