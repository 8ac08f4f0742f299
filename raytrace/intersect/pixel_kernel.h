#pragma once

#include "raytrace/intersect/cubic_in_ball.h"
#include "raytrace/intersect/pixel_record.h"
#include "raytrace/intersect/ray_kernel.h"
#include "raytrace/intersect/root_kernel.h"
#include "slim/base/simd.h"

#include <array>
#include <cstddef>

namespace slim {

/// What a record has in common on one row of pixels.
template <int Degree>
struct RowOf {
    alignas(64) std::array<float, PixelRecord<Degree>::kWidth> c;
    float t;
    float u_t, v_t;  ///< the axes' parts of t

    [[gnu::always_inline]] RowOf(const PixelRecord<Degree>& r, float y)
        : t(r.base_y + (y - r.pixel_y) * r.step), u_t(r.u_axis[1] * t), v_t(r.v_axis[1] * t) {
        constexpr std::size_t kLast = PixelRecord<Degree>::kPowers - 1;
        for (std::size_t i = 0; i < PixelRecord<Degree>::kWidth; ++i) {
            float value = r.row[kLast][i];
            for (std::size_t j = kLast; j-- > 0;) value = value * t + r.row[j][i];
            c[i] = value;
        }
    }
};

template <int Degree, class V>
[[gnu::always_inline]] inline V pixel_offset(const PixelRecord<Degree>& r, const V& x) {
    return (x - V(r.pixel_x)) * V(r.step) + V(r.base_x);
}

template <int Degree, class V>
[[gnu::always_inline]] inline BallLanes<V> ball_lanes(const PixelRecord<Degree>& r, const RowOf<Degree>& row,
                                                      const V& s) {
    constexpr std::size_t k = PixelRecord<Degree>::kBall;
    const auto at = [&](std::size_t i) __attribute__((always_inline)) {
        return V(row.c[k + i]) + s * (V(r.ball_s[i]) + s * V(r.ball_ss[i]));
    };
    return {at(0), at(1), at(2)};
}

/// f along the rays, by powers of tau.
template <int Degree, class V>
[[gnu::always_inline]] inline PolynomialLanes<V> pixel_polynomial(const PixelRecord<Degree>& r,
                                                                  const RowOf<Degree>& row, const V& s) {
    constexpr auto n = static_cast<std::size_t>(Degree);
    PolynomialLanes<V> k{V(0.0f), V(0.0f), V(0.0f), V(0.0f)};
    for (std::size_t p = 0; p <= n; ++p) {
        V value(r.top[p]);
        for (std::size_t i = n; i-- > 0;) value = V(row.c[p * n + i]) + s * value;
        k[p] = value;
    }
    return k;
}

/// The surfel's own (u, v) at tau.
template <class V>
struct PlaneLanes {
    V u, v;
};
template <int Degree, class V>
[[gnu::always_inline]] inline PlaneLanes<V> plane_lanes(const PixelRecord<Degree>& r, const RowOf<Degree>& row,
                                                        const V& s, const V& tau) {
    const V share = 1.0f + tau * V(r.kappa);
    return {tau * V(r.u_tau) + share * (s * V(r.u_axis[0]) + V(row.u_t)),
            tau * V(r.v_tau) + share * (s * V(r.v_axis[0]) + V(row.v_t))};
}

/// Gradient of f times rho at tau, camera axes. For degree 2 it is affine in tau and (1 + kappa tau) (s, t).
template <int Degree, class V>
[[gnu::always_inline]] inline GradientLanes<V> pixel_gradient(const PixelRecord<Degree>& r, const RowOf<Degree>& row,
                                                              const V& s, const V& tau) {
    if constexpr (Degree == 2) {
        constexpr std::size_t k = PixelRecord<2>::kGradient;
        const V share_s = s * (1.0f + tau * V(r.kappa));
        const auto at = [&](std::size_t axis) __attribute__((always_inline)) {
            return V(row.c[k + axis]) + tau * V(row.c[k + 3 + axis]) + share_s * V(r.gradient_s[axis]);
        };
        return {at(0), at(1), at(2)};
    } else {
        const auto [u, v] = plane_lanes<Degree, V>(r, row, s, tau);
        return gradient_at<Degree, V>(r, u, v);
    }
}

/// The smaller root in size of k0 + 2 h t + k2 t^2 is -k0 / q, the other one -q / k2, q = h + sign(h) sqrt(h^2 - k0 k2)
/// (NUMERICS 4.2); q is NaN where there is none.
template <class V>
[[gnu::always_inline]] inline V quadratic_q(const V& k0, const V& h, const V& k2) {
    // Exact products by fma (Kahan): the discriminant near a tangent.
    const V w = k0 * k2;
    const V discriminant = lanes_fma(h, h, -w) - lanes_fma(k0, k2, -w);
    const V inverse = inverse_sqrt(discriminant), root = discriminant * inverse;
    // One more step, for the last bit.
    return h + lanes_copysign(root + (0.5f * inverse) * lanes_fma(-root, root, discriminant), h);
}

/// The first root in a ball of squared radius `sq_radius` at tau >= lo.
/// Lo: a float, or one per lane.
template <int Degree, class V, class Lo>
[[gnu::always_inline]] inline RootLanes<V> first_in_ball(const PolynomialLanes<V>& k, const BallLanes<V>& ball,
                                                         float sq_radius, const Lo& lo) {
    const auto inside = [&](const V& tau) __attribute__((always_inline)) {
        return ball.sq_distance(tau) < V(sq_radius) && tau >= V(lo);
    };
    if constexpr (Degree <= 1) {
        const V tau = -k[0] * reciprocal(k[1]);
        return masked_root<V>(tau, inside(tau));
    } else if constexpr (Degree == 2) {
        const V q = quadratic_q<V>(k[0], 0.5f * k[1], k[2]);
        const V inverse = reciprocal(q), first = -k[0] * inverse;
        const V small = first - inverse * lanes_fma(first, q, k[0]);
        // The other root is seldom anywhere near: |tau| is at most the radius in the ball, which is as deep as it is wide.
        if (stdx::none_of(q * q <= V(sq_radius) * (k[2] * k[2]))) return masked_root<V>(small, inside(small));
        const V large = -q / k[2];
        const V near = stdx::min(small, large), far = stdx::max(small, large);
        const auto near_in = inside(near);
        return masked_root<V>(select<V>(near_in, near, far), near_in || inside(far));
    } else {
        return first_cubic_in_ball<V>(k, ball, sq_radius, lo);
    }
}

/// The root in the ball nearest to 0, ball and f counted from there (`about`); roots farther off than `window` (in
/// q) may be left out.
template <int Degree, class V>
[[gnu::always_inline]] inline RootLanes<V> nearest_in_ball(const PolynomialLanes<V>& k, const BallLanes<V>& ball,
                                                           float window,
                                                           const typename V::mask_type& active) {
    const auto inside = [&](const V& tau) __attribute__((always_inline)) {
        return ball.sq_distance(tau) < V(1.0f);
    };
    if constexpr (Degree <= 1) {
        const V tau = -k[0] * reciprocal(k[1]);
        return masked_root<V>(tau, active && ball.l * (tau * tau) <= window * window && inside(tau));
    } else if constexpr (Degree == 2) {
        const V q = quadratic_q<V>(k[0], 0.5f * k[1], k[2]);
        const V inverse = reciprocal(q), first = -k[0] * inverse;
        const V small = first - inverse * lanes_fma(first, q, k[0]);
        const auto small_in = active && inside(small);
        // The other root is seldom within the window.
        const auto other = active && !small_in && q * q * ball.l <= (window * window) * (k[2] * k[2]);
        if (stdx::none_of(other)) return masked_root<V>(small, small_in);
        const V large = -q / k[2];
        return masked_root<V>(select<V>(small_in, small, large), small_in || (other && inside(large)));
    } else {
        return nearest_cubic_in_ball<V>(k, ball, window, active);
    }
}

}  // namespace slim
