#pragma once

#include "raytrace/intersect/ball_lanes.h"
#include "raytrace/intersect/root_kernel.h"
#include "slim/base/simd.h"

#include <limits>

namespace slim {

/// Roots of k0 + 2 h t + k2 t^2 (NUMERICS 4.2): with q = h + sign(h) sqrt(h^2 - k0 k2) the smaller
/// one in size is -k0 / q, the other one -q / k2; NaN where there is none. Root and quotient are
/// the target's estimates (2^-14) and one step of Newton each, which doubles the bits.
template <class V>
class QuadraticRoots {
public:
    [[gnu::always_inline]] explicit QuadraticRoots(const PolynomialLanes<V>& k) : k_(k) {
        // Exact products by fma (Kahan): the discriminant near a tangent.
        const V h = 0.5f * k[1], w = k[0] * k[2];
        const V discriminant = lanes_fms(h, h, w) - lanes_fms(k[0], k[2], w);
        // The least normal float, lost in all but 0: a tangent has a root.
        const V inverse =
            inverse_sqrt_estimate(discriminant + std::numeric_limits<float>::min());
        const V root = discriminant * inverse;
        const V exact = root + (0.5f * inverse) * lanes_fnma(root, root, discriminant);
        q_ = h + exact;
        stdx::where(h < 0.0f, q_) = h - exact;
    }
    [[gnu::always_inline]] V small() const {
        const V inverse = reciprocal_estimate(q_), quotient = k_[0] * inverse;
        return -quotient - inverse * lanes_fnma(quotient, q_, k_[0]);
    }
    [[gnu::always_inline]] V large() const { return -q_ / k_[2]; }
    /// Where the larger one is at most `reach` in size.
    [[gnu::always_inline]] typename V::mask_type large_within(float reach) const {
        const V most = reach * k_[2];
        return q_ * q_ <= most * most;
    }

private:
    const PolynomialLanes<V>& k_;
    V q_;
};

/// The first root in the ball at tau >= lo; none in the ball is larger than `reach`.
template <class V, class Lo>
[[gnu::always_inline]] inline RootLanes<V> first_quadratic_in_ball(const PolynomialLanes<V>& k,
                                                                   const BallLanes<V>& ball,
                                                                   float reach, const Lo& lo) {
    const auto inside = [&](const V& tau) __attribute__((always_inline)) {
        return ball.value(tau) < V(0.0f) && tau >= V(lo);
    };
    const QuadraticRoots<V> roots(k);
    const V small = roots.small();
    // The other root is seldom anywhere near.
    if (stdx::none_of(roots.large_within(reach))) return masked_root<V>(small, inside(small));
    const V large = roots.large();
    const V near = stdx::min(small, large), far = stdx::max(small, large);
    const auto near_in = inside(near);
    return masked_root<V>(select<V>(near_in, near, far), near_in || inside(far));
}

/// The root in the ball nearest 0; those larger than `reach` may be left out.
template <class V>
[[gnu::always_inline]] inline RootLanes<V> nearest_quadratic_in_ball(
    const PolynomialLanes<V>& k, const BallLanes<V>& ball, float reach,
    const typename V::mask_type& active) {
    const QuadraticRoots<V> roots(k);
    const V small = roots.small();
    const auto small_in = active && ball.value(small) < V(0.0f);
    const auto other = active && !small_in && roots.large_within(reach);
    if (stdx::none_of(other)) return masked_root<V>(small, small_in);
    const V large = roots.large();
    return masked_root<V>(select<V>(small_in, small, large),
                          small_in || (other && ball.value(large) < V(0.0f)));
}

}  // namespace slim
