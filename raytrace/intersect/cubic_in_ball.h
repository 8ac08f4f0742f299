#pragma once

#include "raytrace/intersect/root_kernel.h"
#include "slim/base/simd.h"

namespace slim {

/// |q|^2 = n + m tau + l tau^2 along the rays of some pixels.
template <class V>
struct BallLanes {
    V n, m, l;
    [[gnu::always_inline]] V sq_distance(const V& tau) const { return n + tau * (m + tau * l); }
};

/// f and the ball with tau counted from `at`.
template <class V>
[[gnu::always_inline]] inline PolynomialLanes<V> about(const PolynomialLanes<V>& k, const V& at) {
    return {k[0] + at * (k[1] + at * (k[2] + at * k[3])), k[1] + at * (2.0f * k[2] + at * (3.0f * k[3])),
            k[2] + at * (3.0f * k[3]), k[3]};
}
template <class V>
[[gnu::always_inline]] inline BallLanes<V> about(const BallLanes<V>& b, const V& at) {
    return {b.sq_distance(at), b.m + at * (2.0f * b.l), b.l};
}

/// A root by Newton from 0, and the lanes where it is known to have come to rest.
template <class V>
[[gnu::always_inline]] inline RootLanes<V> newton_root(const PolynomialLanes<V>& k, int n_steps) {
    constexpr float u = std::numeric_limits<float>::epsilon() / 2;
    V t = -k[0] * reciprocal(k[1]);
    for (int i = 1; i < n_steps; ++i)
        t = t - lanes_value(k, t) * reciprocal(k[1] + t * (2.0f * k[2] + t * (3.0f * k[3])));
    return {t, stdx::abs(lanes_value(k, t)) <= 4 * u * rounding_size(k, t)};
}

/// The interval of tau in a ball; NaN where the ray misses it.
template <class V>
struct TauInterval {
    V lo, hi;
    [[gnu::always_inline]] TauInterval(const BallLanes<V>& b, float sq_radius) {
        const V inv_l = 1.0f / b.l, middle = -0.5f * b.m * inv_l;
        const V half = stdx::sqrt(middle * middle - (b.n - sq_radius) * inv_l);
        lo = middle - half, hi = middle + half;
    }
};

/// Cubics: where f' cannot vanish in the ball, Newton's few steps find the one root there is; lanes of which that is not
/// known take the sure way (NUMERICS 4.2), which costs a hundred times as much.
template <class V, class Lo>
[[gnu::always_inline]] inline RootLanes<V> first_cubic_in_ball(const PolynomialLanes<V>& k, const BallLanes<V>& ball,
                                                               float sq_radius, const Lo& lo) {
    const TauInterval<V> chord(ball, sq_radius);
    const auto met = chord.hi >= V(lo);
    const V middle = 0.5f * (chord.lo + chord.hi), half = chord.hi - middle;
    const PolynomialLanes<V> f = about(k, middle);
    const RootLanes<V> fast = newton_root<V>(f, 4);
    const auto monotone = stdx::abs(f[1]) > half * (2.0f * stdx::abs(f[2]) + 3.0f * half * stdx::abs(f[3]));
    // Where f keeps its sign over a chord on which it is monotone there is no root to wait for.
    const V rise = half * (f[1] + half * half * f[3]), mean = f[0] + half * half * f[2];
    const auto no_root = monotone && stdx::abs(mean) > stdx::abs(rise) * 1.0001f;
    const V tau = middle + fast.t;
    const auto sure = monotone && fast.hit;
    const auto hit = met && sure && !no_root && ball.sq_distance(tau) < V(sq_radius) && tau >= V(lo);
    const auto open = met && !sure && !no_root;
    if (stdx::none_of(open)) return masked_root<V>(tau, hit);
    const RootLanes<V> slow = first_root<3, V>(k, stdx::max(chord.lo, V(lo)), chord.hi, open);
    return masked_root<V>(select<V>(open, slow.t, tau), hit || (open && slow.hit));
}

/// The root nearest 0, ball and f counted from there; roots farther off than `window` (in q) may be left out.
template <class V>
[[gnu::always_inline]] inline RootLanes<V> nearest_cubic_in_ball(const PolynomialLanes<V>& k, const BallLanes<V>& ball,
                                                                 float window,
                                                                 const typename V::mask_type& active) {
    const RootLanes<V> fast = newton_root<V>(k, 3);
    const V size = stdx::abs(fast.t), k1 = stdx::abs(k[1]), k2 = stdx::abs(k[2]), k3 = stdx::abs(k[3]);
    // f' keeps its sign up to that root on either side: none is nearer.
    const auto nearest = k1 > size * (2.0f * k2 + 3.0f * size * k3);
    const auto hit = active && fast.hit && nearest && ball.sq_distance(fast.t) < V(1.0f);
    auto open = active && !hit;
    if (stdx::none_of(open)) return masked_root<V>(fast.t, hit);
    const V r = window / stdx::sqrt(ball.l);
    open = open && stdx::abs(k[0]) <= r * (k1 + r * (k2 + r * k3));
    if (stdx::none_of(open)) return masked_root<V>(fast.t, hit);
    const TauInterval<V> chord(ball, 1);
    const RootLanes<V> slow = nearest_root<3, V>(k, V(0.0f), chord.lo, chord.hi, open);
    return masked_root<V>(select<V>(open, slow.t, fast.t), hit || (open && slow.hit));
}

}  // namespace slim
