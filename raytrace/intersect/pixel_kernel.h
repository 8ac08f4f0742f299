#pragma once

#include "raytrace/intersect/cubic_in_ball.h"
#include "raytrace/intersect/pixel_record.h"
#include "raytrace/intersect/quadratic_in_ball.h"
#include "raytrace/intersect/ray_kernel.h"
#include "raytrace/intersect/root_kernel.h"
#include "slim/base/simd.h"

#include <array>
#include <cstddef>

namespace slim {

/// What a record has in common where t is: pixels of one row, or of rows that repeat along a strip
/// of blocks. Of quadrics, coefficients in s and tau are worked out where they are used: numbers
/// loaded before a branch and spread to lanes after it are two instructions each instead of a part
/// of the product (project/notes/0008).
template <int Degree, class V>
class RowOf {
public:
    [[gnu::always_inline]] RowOf(const PixelRecord<Degree>& record, const V& at_t, float sq_radius)
        : r(record), t(at_t) {
        ball_n = t * t - V(sq_radius);
        ball_m = t * V(r.ball_t) + V(2 * r.kappa * sq_radius);
        ball_l = V(r.ball_tau - r.kappa * r.kappa * sq_radius);
        std::size_t at = 0;
        if constexpr (!kAtUse)
            for (int p = 0; p < Degree; ++p)
                for (int i = 0; i < Degree - p; ++i) in_s[at++] = coefficient(p, i);
    }

    /// h^2 (|q|^2 - R^2).
    [[gnu::always_inline]] BallLanes<V> ball(const V& s) const {
        return {ball_n + s * s, ball_m + s * V(r.ball_s), ball_l};
    }

    /// h^Degree f by powers of tau.
    [[gnu::always_inline]] PolynomialLanes<V> polynomial(const V& s) const {
        PolynomialLanes<V> k{V(0.0f), V(0.0f), V(0.0f), V(0.0f)};
        std::size_t at = 0;
        for (int p = 0; p <= Degree; ++p) {
            const int n = Degree - p;
            V value(r.f[power_start(Degree, p) + n_planar(n - 1)]);
            for (int i = n; i-- > 0;) {
                if constexpr (kAtUse) value = coefficient(p, i) + s * value;
                else value = in_s[at + static_cast<std::size_t>(i)] + s * value;
            }
            at += static_cast<std::size_t>(n);
            k[static_cast<std::size_t>(p)] = value;
        }
        return k;
    }

    /// The surfel's own (u, v) at tau; share is 1 / h there.
    struct Plane {
        V u, v;
    };
    [[gnu::always_inline]] Plane plane(const V& s, const V& tau, const V& share) const {
        return {share * (s * V(r.u[0]) + t * V(r.u[1]) + tau * V(r.u[2])),
                share * (s * V(r.v[0]) + t * V(r.v[1]) + tau * V(r.v[2]))};
    }

    /// Gradient of f times rho, camera axes.
    [[gnu::always_inline]] GradientLanes<V> gradient(const V& s, const V& tau,
                                                     const V& share) const {
        if constexpr (Degree == 2) {
            const auto at = [&](std::size_t axis) __attribute__((always_inline)) {
                const auto& g = r.gradient[axis];
                return share * (V(g[0]) + t * V(g[2]) + s * V(g[1]) + tau * V(g[3]));
            };
            return {at(0), at(1), at(2)};
        } else {
            const auto [u, v] = plane(s, tau, share);
            return gradient_at<Degree, V>(r, u, v);
        }
    }

    /// 1 / h.
    [[gnu::always_inline]] V share(const V& tau) const { return reciprocal(height(tau)); }
    [[gnu::always_inline]] V height(const V& tau) const { return 1.0f - tau * V(r.kappa); }

private:
    static constexpr bool kAtUse = Degree == 2;
    /// The coefficient of s^i tau^p.
    [[gnu::always_inline]] V coefficient(int p, int i) const {
        const int n = Degree - p;
        const auto term = [&](int j) __attribute__((always_inline)) {
            return V(
                r.f[power_start(Degree, p) + n_planar(i + j - 1) + static_cast<std::size_t>(j)]);
        };
        V value = term(n - i);
        for (int j = n - i; j-- > 0;) value = term(j) + t * value;
        return value;
    }

    const PixelRecord<Degree>& r;
    V t, ball_n, ball_m, ball_l;
    std::array<V, kAtUse ? 0 : n_planar(Degree - 1)> in_s;
};

/// The first root in a ball at tau >= lo; none in the ball is larger than `reach`. Lo: a float,
/// or one per lane.
template <int Degree, class V, class Lo>
[[gnu::always_inline]] inline RootLanes<V> first_in_ball(const PolynomialLanes<V>& k,
                                                         const BallLanes<V>& ball, float reach,
                                                         const Lo& lo) {
    if constexpr (Degree <= 1) {
        const V tau = -k[0] * reciprocal(k[1]);
        return masked_root<V>(tau, ball.value(tau) < V(0.0f) && tau >= V(lo));
    } else if constexpr (Degree == 2) {
        return first_quadratic_in_ball<V>(k, ball, reach, lo);
    } else {
        return first_cubic_in_ball<V>(k, ball, lo);
    }
}

/// The root in the ball nearest to 0, ball and f counted from there (`about`); those farther off
/// than `reach` may be left out.
template <int Degree, class V>
[[gnu::always_inline]] inline RootLanes<V> nearest_in_ball(const PolynomialLanes<V>& k,
                                                           const BallLanes<V>& ball, float reach,
                                                           const typename V::mask_type& active) {
    if constexpr (Degree <= 1) {
        const V tau = -k[0] * reciprocal(k[1]);
        return masked_root<V>(tau, active && ball.value(tau) < V(0.0f));
    } else if constexpr (Degree == 2) {
        return nearest_quadratic_in_ball<V>(k, ball, reach, active);
    } else {
        return nearest_cubic_in_ball<V>(k, ball, reach, active);
    }
}

}  // namespace slim
