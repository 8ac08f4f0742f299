#pragma once

#include "slim/base/simd.h"

#include <array>

namespace slim {

/// Principal frame and curvatures, in the axes of the gradient.
template <class V>
struct PrincipalLanes {
    std::array<V, 3> normal, t1, t2;
    V k1, k2, inv_len;  ///< inv_len: 1 / |g|
};

template <class V>
inline V dot_lanes(const std::array<V, 3>& a, const std::array<V, 3>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

template <class V>
inline std::array<V, 3> times_lanes(const std::array<V, 6>& h, const std::array<V, 3>& a) {
    return {h[0] * a[0] + h[1] * a[1] + h[2] * a[2], h[1] * a[0] + h[3] * a[1] + h[4] * a[2],
            h[2] * a[0] + h[4] * a[1] + h[5] * a[2]};
}

/// Cosine and sine of half the angle of (x, y), x >= 0 taken as cosine > 0; (1, 0) for the zero
/// vector.
template <class V>
inline void half_angle(const V& x, const V& y, V& c, V& s) {
    const V r = stdx::sqrt(x * x + y * y);
    const auto some = r > 0.0f;
    const V inv = 1.0f / select<V>(some, r, V(1.0f));
    const V cos = select<V>(some, x * inv, V(1.0f)), sin = y * inv;
    const V larger = stdx::sqrt(0.5f + 0.5f * stdx::abs(cos));
    const V smaller = 0.5f * stdx::abs(sin) / larger;
    const auto right = cos >= 0.0f;
    c = select<V>(right, larger, smaller);
    s = stdx::copysign(select<V>(right, smaller, larger), sin);
}

/// Lanes of the directions of third_order_from in slim/blend/curvature.h: no angle is ever formed.
template <class V>
inline PrincipalLanes<V> principal_lanes(const V& gx, const V& gy, const V& gz,
                                         const std::array<V, 6>& h) {
    const V inv_len = 1.0f / stdx::sqrt(gx * gx + gy * gy + gz * gz);
    const std::array<V, 3> n{gx * inv_len, gy * inv_len, gz * inv_len};
    // The tangent basis of Duff et al. (JCGT 2017).
    const V sign = stdx::copysign(V(1.0f), n[2]);
    const V a = -1.0f / (sign + n[2]);
    const V b = n[0] * n[1] * a;
    const std::array<V, 3> u{1.0f + sign * n[0] * n[0] * a, sign * b, -sign * n[0]};
    const std::array<V, 3> v{b, sign + n[1] * n[1] * a, -n[1]};
    const auto hu = times_lanes(h, u), hv = times_lanes(h, v);
    const V s11 = dot_lanes(u, hu) * inv_len, s12 = dot_lanes(u, hv) * inv_len;
    const V s22 = dot_lanes(v, hv) * inv_len;
    const V mean = 0.5f * (s11 + s22), half = 0.5f * (s11 - s22);
    const V spread = stdx::sqrt(half * half + s12 * s12);
    V c, s;
    half_angle(half, s12, c, s);
    PrincipalLanes<V> out{n, {}, {}, mean + spread, mean - spread, inv_len};
    for (std::size_t i = 0; i < 3; ++i) {
        out.t1[i] = c * u[i] + s * v[i];
        out.t2[i] = c * v[i] - s * u[i];
    }
    return out;
}

/// C(., ., a) for c as third_of writes it.
template <class V>
inline std::array<V, 6> contract_lanes(const std::array<V, 10>& c, const std::array<V, 3>& a) {
    return {c[0] * a[0] + c[1] * a[1] + c[2] * a[2], c[1] * a[0] + c[3] * a[1] + c[4] * a[2],
            c[2] * a[0] + c[4] * a[1] + c[5] * a[2], c[3] * a[0] + c[6] * a[1] + c[7] * a[2],
            c[4] * a[0] + c[7] * a[1] + c[8] * a[2], c[5] * a[0] + c[8] * a[1] + c[9] * a[2]};
}

/// Lanes of third_order_from: dk1/dt1, dk1/dt2, dk2/dt1, dk2/dt2.
template <class V>
inline std::array<V, 4> third_order_lanes(const PrincipalLanes<V>& p, const std::array<V, 6>& h,
                                          const std::array<V, 10>& c) {
    const auto hn = times_lanes(h, p.normal);
    const V h1 = dot_lanes(hn, p.t1), h2 = dot_lanes(hn, p.t2);
    const auto c11 = times_lanes(contract_lanes(c, p.t1), p.t1);
    const auto c22 = times_lanes(contract_lanes(c, p.t2), p.t2);
    return {(dot_lanes(c11, p.t1) - 3.0f * p.k1 * h1) * p.inv_len,
            (dot_lanes(c11, p.t2) - p.k1 * h2) * p.inv_len,
            (dot_lanes(c22, p.t1) - p.k2 * h1) * p.inv_len,
            (dot_lanes(c22, p.t2) - 3.0f * p.k2 * h2) * p.inv_len};
}

}  // namespace slim
