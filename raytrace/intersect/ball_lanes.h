#pragma once

#include "raytrace/intersect/root_kernel.h"
#include "slim/base/simd.h"

namespace slim {

/// n + m tau + l tau^2 along the rays of some pixels, negative inside a ball.
template <class V>
struct BallLanes {
    V n, m, l;
    [[gnu::always_inline]] V value(const V& tau) const { return n + tau * (m + tau * l); }
};

/// f and the ball with tau counted from `at`.
template <class V>
[[gnu::always_inline]] inline PolynomialLanes<V> about(const PolynomialLanes<V>& k, const V& at) {
    return {k[0] + at * (k[1] + at * (k[2] + at * k[3])),
            k[1] + at * (2.0f * k[2] + at * (3.0f * k[3])), k[2] + at * (3.0f * k[3]), k[3]};
}
template <class V>
[[gnu::always_inline]] inline BallLanes<V> about(const BallLanes<V>& b, const V& at) {
    return {b.value(at), b.m + at * (2.0f * b.l), b.l};
}

/// The interval of tau in a ball; NaN where the ray misses it.
template <class V>
struct TauInterval {
    V lo, hi;
    [[gnu::always_inline]] explicit TauInterval(const BallLanes<V>& b) {
        const V inv_l = 1.0f / b.l, middle = -0.5f * b.m * inv_l;
        const V half = stdx::sqrt(middle * middle - b.n * inv_l);
        lo = middle - half, hi = middle + half;
    }
};

}  // namespace slim
