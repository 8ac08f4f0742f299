#include "slim/cover/blend_refit.h"

#include "slim/base/parallel.h"
#include "slim/fit/ball_points.h"
#include "slim/fit/local_fit.h"
#include "slim/model/rim.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <vector>

namespace slim {
namespace {

/// Of the variance that a fit of K coefficients to n_eff independent residuals has: the leaf's own
/// residuals are orthogonal to it already, and the blend averages its neighbours'.
constexpr double kChance = 0.3;
constexpr double kLeastFreedom = 0.25;  // eps^2 grows fourfold at most by its correction (LocalFit)
constexpr double kOutside = 2;          // squared distance of a point that
                                        // takes no part (BallPoints)

/// Puts the ball's points where the leaf must add height: at (u, v, off / rho). Points that are no
/// part of its surface, by place or normal, are left out. Returns the mean square of the heights
/// under G.
double aim_at_blend(const PointTree& points, const Surfel& s,
                    std::span<const BlendResidual> residuals, BallPoints<double>& ball) {
    double weight = 0, square = 0;
    for (std::size_t i = 0; i < ball.n; ++i) {
        const Vec3d x{ball.x[i], ball.y[i], ball.z[i]};
        const Vec3d local = s.frame.local_from_world(x);
        const bool is_alike = dot(s.frame.normal, {ball.nx[i], ball.ny[i], ball.nz[i]}) > kLeastCos;
        const BlendResidual& r = residuals[points.source(ball.index[i])];
        if (!is_alike || !(r.weight > 0) ||
            !(std::abs(local.z - s.polynomial.value(local.x, local.y)) <= kBelongs)) {
            ball.sq[i] = kOutside;
            continue;
        }
        const double height = r.off() / s.support_radius, g = weight_kernel(ball.sq[i]);
        weight += g, square += g * height * height;
        const Vec3d aim = x + s.frame.normal * (height - local.z);
        ball.x[i] = aim.x, ball.y[i] = aim.y, ball.z[i] = aim.z;
    }
    return weight > 0 ? square / weight : 0;
}

/// What a fit explains of a mean square, over rho squared, and the share of it that is believed
/// when chance is taken off (James and Stein's positive part).
struct Belief {
    double explained = 0, share = 0;
};
Belief believed(const LocalFit& fit, double radius, double mean_square) {
    const double k = n_coefficients(fit.degree);
    const double rest =
        fit.sq_error / (radius * radius) * std::max(1 - k / fit.n_effective, kLeastFreedom);
    const double explained = mean_square - rest;
    if (!(explained > 0)) return {};
    return {explained, std::max(0.0, 1 - kChance * k * rest / (fit.n_effective * explained))};
}

/// By how much a leaf's move changes BlendResidual::height at a point.
struct HeightMove {
    std::uint32_t point;
    float height;
};

/// What a leaf's move by share * polynomial does at the ball's points that are part of its surface.
std::vector<HeightMove> height_moves(const PointTree& points, const Surfel& s, double share,
                                     const Polynomial<double>& polynomial,
                                     const BallPoints<double>& ball) {
    std::vector<HeightMove> out;
    out.reserve(ball.n);
    for (std::size_t i = 0; i < ball.n; ++i) {
        if (!(ball.sq[i] < 1)) continue;
        const Vec3d x = s.frame.local_from_world({ball.x[i], ball.y[i], ball.z[i]});
        const double weight = weight_kernel(ball.sq[i]) * rim_share(s.rims, x.x, x.y);
        const double up = share * polynomial.value(x.x, x.y) * s.support_radius;
        out.push_back({points.source(ball.index[i]), static_cast<float>(-weight * up)});
    }
    return out;
}

/// moves: filled in unless null.
bool refit(const PointTree& points, std::span<const BlendResidual> residuals, FittedSurfel& leaf,
           BallPoints<double>& ball, std::vector<HeightMove>* moves) {
    Surfel& s = leaf.surfel;
    if (s.sharp || s.degree < 1) return false;
    gather_ball(points, s.center, s.support_radius, ball);
    const double mean_square = aim_at_blend(points, s, residuals, ball);
    const LocalFit fit = fit_ball(ball, 1, s.frame, s.degree, Enough::points);
    if (fit.fallback != Fallback::none) return false;
    const Belief belief = believed(fit, s.support_radius, mean_square);
    if (!(belief.share > 0)) return false;
    Polynomial<double> moved = s.polynomial;
    for (std::size_t k = 0; k < moved.a.size(); ++k)
        moved.a[k] += belief.share * fit.polynomial.a[k];
    if (too_steep(moved)) return false;
    s.polynomial = moved;
    if (moves) *moves = height_moves(points, s, belief.share, fit.polynomial, ball);
    // Its own residuals are orthogonal to what it may move by.
    leaf.fit_error =
        std::hypot(leaf.fit_error, belief.share * std::sqrt(belief.explained) * s.support_radius);
    return true;
}

}  // namespace

std::size_t refit_to_blend(const PointTree& points, std::span<const BlendResidual> residuals,
                           std::span<FittedSurfel* const> leaves, std::span<float> moved) {
    std::vector<std::vector<HeightMove>> moves(moved.empty() ? 0 : leaves.size());
    tbb::enumerable_thread_specific<BallPoints<double>> balls;
    std::atomic<std::size_t> n_moved = 0;
    parallel_blocks(leaves.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            n_moved += refit(points, residuals, *leaves[i], balls.local(),
                             moves.empty() ? nullptr : &moves[i])
                           ? 1u
                           : 0u;
    });
    // one after the other: sums do not depend on threads
    for (const std::vector<HeightMove>& of_leaf : moves)
        for (const HeightMove& m : of_leaf) moved[m.point] += m.height;
    return n_moved;
}

}  // namespace slim
