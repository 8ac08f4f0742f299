#pragma once

#include "slim/base/frame.h"
#include "slim/fit/ball_points.h"
#include "slim/model/polynomial.h"
#include "slim/model/weight_kernel.h"

#include <array>
#include <type_traits>
#include <utility>

namespace slim {

/// Weighted sums of a height-field fit of one degree, coordinates divided by the gather radius:
/// A = sum G phi phi^T holds only the monomials up to twice the degree (NUMERICS 2.2).
template <int Degree>
struct Moments {
    static constexpr int kBasis = n_coefficients(Degree);
    static constexpr int kMonomials = n_coefficients(2 * Degree);
    std::array<double, kMonomials> monomial{};  ///< sum G u^a v^b, basis order continued
    std::array<double, kBasis> height{};        ///< sum G w phi
    double sq_height = 0;                       ///< sum G w^2
    double sq_weight = 0;                       ///< sum G^2

    double weight() const { return monomial[0]; }
    double n_effective() const {
        return sq_weight > 0 ? weight() * weight() / sq_weight : 0;
    }
};

namespace detail {

/// The lanes of floats are added as doubles, by halves: lane after lane costs as much as the points of a ball.
template <class V>
double lane_sum(const V& v) {
    if constexpr (std::is_same_v<typename V::value_type, double> || V::size() % 2 != 0) {
        return static_cast<double>(stdx::reduce(v));
    } else {
        using Half = LanesOfDouble<double>;
        const auto [low, high] = stdx::split<V::size() / 2, V::size() / 2>(v);
        return stdx::reduce(stdx::static_simd_cast<Half>(low) + stdx::static_simd_cast<Half>(high));
    }
}

/// Sums kept in lanes over a few groups of points, then emptied into doubles.
template <int Degree, class V>
struct LaneMoments {
    std::array<V, Moments<Degree>::kMonomials> monomial{};
    std::array<V, Moments<Degree>::kBasis> height{};
    V sq_height{}, sq_weight{};

    void add(const V& g, const V& u, const V& v, const V& w) {
        std::array<V, Moments<Degree>::kMonomials> m;
        m[0] = g;
        std::size_t below = 0, at = 1;
        for (int d = 1; d <= 2 * Degree; ++d) {
            for (int t = 0; t < d; ++t) m[at++] = m[below + static_cast<std::size_t>(t)] * u;
            m[at] = m[at - static_cast<std::size_t>(d) - 1] * v;
            ++at;
            below += static_cast<std::size_t>(d);
        }
        for (std::size_t k = 0; k < m.size(); ++k) monomial[k] += m[k];
        for (std::size_t k = 0; k < height.size(); ++k) height[k] += m[k] * w;
        sq_height += g * w * w;
        sq_weight += g * g;
    }
    void flush(Moments<Degree>& out) {
        for (std::size_t k = 0; k < monomial.size(); ++k)
            out.monomial[k] += lane_sum(std::exchange(monomial[k], V{}));
        for (std::size_t k = 0; k < height.size(); ++k)
            out.height[k] += lane_sum(std::exchange(height[k], V{}));
        out.sq_height += lane_sum(std::exchange(sq_height, V{}));
        out.sq_weight += lane_sum(std::exchange(sq_weight, V{}));
    }
};

}  // namespace detail

/// Sums over the ball's points with weights G at |x| / shrink, shrink <= 1 being the fit's radius over the
/// gather radius. Products in T, lanes emptied into doubles every 16 groups.
template <int Degree, class T>
[[gnu::flatten]] Moments<Degree> accumulate_moments(const BallPoints<T>& points, const Frame<double>& frame,
                                   double shrink) {
    using V = stdx::native_simd<T>;
    const auto axis = [](const Vec3d& a) { return Vec3<V>{V(T(a.x)), V(T(a.y)), V(T(a.z))}; };
    const Vec3<V> eu = axis(frame.u_axis), ev = axis(frame.v_axis), en = axis(frame.normal);
    const V to_fit = V(T(1 / (shrink * shrink)));
    Moments<Degree> sums;
    detail::LaneMoments<Degree, V> lanes;
    int groups = 0;
    for (std::size_t i = 0; i < points.padded(); i += V::size()) {
        const V x(&points.x[i], stdx::element_aligned), y(&points.y[i], stdx::element_aligned),
            z(&points.z[i], stdx::element_aligned), sq(&points.sq[i], stdx::element_aligned);
        const V g = fit_weight(points.weight, sq * to_fit);
        lanes.add(g, eu.x * x + eu.y * y + eu.z * z, ev.x * x + ev.y * y + ev.z * z,
                  en.x * x + en.y * y + en.z * z);
        if (++groups == 16) {
            lanes.flush(sums);
            groups = 0;
        }
    }
    lanes.flush(sums);
    return sums;
}

}  // namespace slim
