#pragma once

#include "raytrace/intersect/ball_lanes.h"
#include "raytrace/intersect/root_kernel.h"
#include "slim/base/simd.h"

namespace slim {

/// What Newton's steps arrive at, and where the last one was so short that the next would be below
/// the last bits.
template <class V>
[[gnu::always_inline]] inline RootLanes<V> newton_root(const PolynomialLanes<V>& k, V t,
                                                       int n_steps) {
    constexpr float kShort = 3e-4f;
    const V twice = 2.0f * k[2], thrice = 3.0f * k[3];
    V step(0.0f);
    for (int i = 0; i < n_steps; ++i) {
        step = lanes_value(k, t) * reciprocal_estimate(k[1] + t * (twice + t * thrice));
        t = t - step;
    }
    return {t, stdx::abs(step) <= kShort};
}

/// The smaller root of what is left of a cubic without its last term, to about 2^-13.
template <class V>
[[gnu::always_inline]] inline V quadratic_estimate(const PolynomialLanes<V>& k) {
    const V h = 0.5f * k[1], discriminant = h * h - k[0] * k[2];
    const V root = lanes_copysign(discriminant * inverse_sqrt_estimate(discriminant), h);
    return -k[0] * reciprocal_estimate(h + root);
}

/// Cubics: where f' cannot vanish in the ball, Newton's few steps find the one root there is; lanes
/// of which that is not known take the sure way (NUMERICS 4.2),
/// which costs a hundred times as much.
template <class V, class Lo>
[[gnu::always_inline]] inline RootLanes<V> first_cubic_in_ball(const PolynomialLanes<V>& k,
                                                               const BallLanes<V>& ball,
                                                               const Lo& lo) {
    const V inv_l = reciprocal(ball.l), middle = -0.5f * ball.m * inv_l;
    const V sq_half = middle * middle - ball.n * inv_l;
    // NaN where the ray misses the ball
    const V half = 1.0002f * (sq_half * inverse_sqrt_estimate(sq_half));
    const PolynomialLanes<V> f = about(k, middle);
    const RootLanes<V> fast = newton_root<V>(f, quadratic_estimate<V>(f), 2);
    const auto monotone =
        stdx::abs(f[1]) > half * (2.0f * stdx::abs(f[2]) + 3.0f * half * stdx::abs(f[3]));
    // Where f keeps its sign over a chord on which it is monotone there is no root to wait for.
    const V rise = half * (f[1] + half * half * f[3]), mean = f[0] + half * half * f[2];
    const auto no_root = monotone && stdx::abs(mean) > stdx::abs(rise) * 1.0001f;
    const V tau = middle + fast.t;
    const auto sure = monotone && (fast.hit || no_root);
    const auto hit = sure && !no_root && ball.value(tau) < V(0.0f) && tau >= V(lo);
    const auto open = middle + half >= V(lo) && !sure;
    if (stdx::none_of(open)) return masked_root<V>(tau, hit);
    const TauInterval<V> chord(ball);
    const RootLanes<V> slow = first_root<3, V>(k, stdx::max(chord.lo, V(lo)), chord.hi, open);
    return masked_root<V>(select<V>(open, slow.t, tau), hit || (open && slow.hit));
}

/// The root nearest 0, ball and f counted from there; roots farther off than `reach` may be left
/// out.
template <class V>
[[gnu::always_inline]] inline RootLanes<V> nearest_cubic_in_ball(
    const PolynomialLanes<V>& k, const BallLanes<V>& ball, float reach,
    const typename V::mask_type& active) {
    const RootLanes<V> fast = newton_root<V>(k, -k[0] * reciprocal_estimate(k[1]), 2);
    const V k1 = stdx::abs(k[1]), k2 = stdx::abs(k[2]), k3 = stdx::abs(k[3]);
    // f' keeps its sign up to that root on either side: none is nearer.
    const auto keeps_sign = [&](const V& size) __attribute__((always_inline)) {
        return k1 > size * (2.0f * k2 + 3.0f * size * k3);
    };
    const auto sure = fast.hit && keeps_sign(stdx::abs(fast.t));
    const auto hit = active && sure && ball.value(fast.t) < V(0.0f);
    auto open = active && !hit;
    if (stdx::none_of(open)) return masked_root<V>(fast.t, hit);
    // Within reach no other root, or none at all.
    const V far(reach);
    open =
        open && !(sure && keeps_sign(far)) && stdx::abs(k[0]) <= far * (k1 + far * (k2 + far * k3));
    if (stdx::none_of(open)) return masked_root<V>(fast.t, hit);
    const TauInterval<V> chord(ball);
    const RootLanes<V> slow = nearest_root<3, V>(k, V(0.0f), chord.lo, chord.hi, open);
    return masked_root<V>(select<V>(open, slow.t, fast.t), hit || (open && slow.hit));
}

}  // namespace slim
