#pragma once

#include "slim/base/simd.h"

#include <array>
#include <limits>

namespace slim {

/// A root per lane and which lanes have one. Elsewhere `t` is 0, so that what is computed from it
/// stays finite.
template <class V>
struct RootLanes {
    V t;
    typename V::mask_type hit;
};

/// k[0] + k[1] t + k[2] t^2 + k[3] t^3 per lane.
template <class V>
using PolynomialLanes = std::array<V, 4>;

template <class V>
inline V lanes_value(const PolynomialLanes<V>& k, const V& t) {
    return k[0] + t * (k[1] + t * (k[2] + t * k[3]));
}

/// Both roots of a quadratic, NaN or infinite where there is none (NUMERICS 4.2): the lanes of
/// quadratic_roots in slim/blend/roots.h.
template <class V>
struct RootPair {
    V near, far;
};

template <class V>
inline RootPair<V> quadratic_pair(const V& k0, const V& k1, const V& k2) {
    constexpr float u = std::numeric_limits<float>::epsilon() / 2;
    const V w = 4.0f * k2 * k0;
    const V discriminant = stdx::fma(k1, k1, -w) + stdx::fma(-4.0f * k2, k0, w);
    const V tangent = select<V>(stdx::abs(discriminant) < 8 * u * k1 * k1, V(0.0f), discriminant);
    const V q = -0.5f * (k1 + stdx::copysign(stdx::sqrt(tangent), k1));
    const V a = k0 / q, b = q / k2;
    return {stdx::min(a, b), stdx::max(a, b)};
}

template <class V>
[[gnu::always_inline]] inline RootLanes<V> masked_root(const V& t,
                                                       const typename V::mask_type& hit) {
    return {select<V>(hit, t, V(0.0f)), hit};
}

/// First root in [lo, hi]. Degree 1 reads k[0], k[1] only, degree 2 also k[2].
template <int Degree, class V>
inline RootLanes<V> first_root(const PolynomialLanes<V>& k, const V& lo, const V& hi,
                               const typename V::mask_type& active);

/// Root in [lo, hi] nearest to `guess`.
template <int Degree, class V>
inline RootLanes<V> nearest_root(const PolynomialLanes<V>& k, const V& guess, const V& lo,
                                 const V& hi, const typename V::mask_type& active);

/// The cubic's interval cut at its stationary points; f at the cuts, values within rounding of zero
/// set to zero.
template <class V>
struct CubicPieces {
    std::array<V, 4> t, f;

    typename V::mask_type has_root(std::size_t i) const { return f[i] * f[i + 1] <= 0.0f; }
};

template <class V>
inline V rounding_size(const PolynomialLanes<V>& k, const V& t) {
    const V x = stdx::abs(t);
    return stdx::abs(k[0]) +
           x * (stdx::abs(k[1]) + x * (stdx::abs(k[2]) + x * stdx::abs(k[3])));
}

template <class V>
inline CubicPieces<V> cut_cubic(const PolynomialLanes<V>& k, const V& lo, const V& hi) {
    constexpr float u = std::numeric_limits<float>::epsilon() / 2;
    const RootPair<V> cuts = quadratic_pair<V>(k[1], 2.0f * k[2], 3.0f * k[3]);
    // A cut that does not exist (NaN) becomes the end of the interval.
    const V near = select<V>(cuts.near <= hi, stdx::max(cuts.near, lo), hi);
    const V far = select<V>(cuts.far <= hi, stdx::max(cuts.far, near), hi);
    CubicPieces<V> pieces{{lo, near, far, hi}, {}};
    for (std::size_t i = 0; i < 4; ++i) {
        const V f = lanes_value(k, pieces.t[i]);
        const V size = rounding_size(k, pieces.t[i]);
        pieces.f[i] = select<V>(stdx::abs(f) <= 4 * u * size, V(0.0f), f);
    }
    return pieces;
}

/// Newton guarded by bisection in [a, b], per lane until |f| <= 4 u sum |k_i t^i|. A lane stops by
/// itself, so that its result does not depend on its neighbours.
template <class V>
inline V solve_piece(const PolynomialLanes<V>& k, V a, V b, const typename V::mask_type& rising,
                     const typename V::mask_type& active) {
    constexpr float u = std::numeric_limits<float>::epsilon() / 2;
    const V linear = -k[0] / k[1];
    V t = select<V>(linear > a && linear < b, linear, 0.5f * (a + b));
    typename V::mask_type open = active;
    for (int i = 0; i < 40 && stdx::any_of(open); ++i) {
        const V f = lanes_value(k, t);
        open = open && stdx::abs(f) > 4 * u * rounding_size(k, t);
        const auto above = (f > 0.0f) == rising;
        b = select<V>(above, t, b);
        a = select<V>(above, a, t);
        const V step = t - f / (k[1] + t * (2.0f * k[2] + t * 3.0f * k[3]));
        const V next = select<V>(step > a && step < b, step, 0.5f * (a + b));
        open = open && next != t;
        t = select<V>(open, next, t);
    }
    return t;
}

template <int Degree, class V>
inline RootLanes<V> first_root(const PolynomialLanes<V>& k, const V& lo, const V& hi,
                               const typename V::mask_type& active) {
    if constexpr (Degree <= 1) {
        const V t = -k[0] / k[1];
        return masked_root<V>(t, active && t >= lo && t <= hi);
    } else if constexpr (Degree == 2) {
        const RootPair<V> roots = quadratic_pair(k[0], k[1], k[2]);
        const auto near_in = roots.near >= lo && roots.near <= hi;
        const auto far_in = roots.far >= lo && roots.far <= hi;
        return masked_root<V>(select<V>(near_in, roots.near, roots.far),
                              active && (near_in || far_in));
    } else {
        const CubicPieces<V> p = cut_cubic(k, lo, hi);
        const auto in_0 = p.has_root(0), in_1 = p.has_root(1), in_2 = p.has_root(2);
        const V a = select<V>(in_0, p.t[0], select<V>(in_1, p.t[1], p.t[2]));
        const V b = select<V>(in_0, p.t[1], select<V>(in_1, p.t[2], p.t[3]));
        const V fa = select<V>(in_0, p.f[0], select<V>(in_1, p.f[1], p.f[2]));
        const V fb = select<V>(in_0, p.f[1], select<V>(in_1, p.f[2], p.f[3]));
        const auto hit = active && lo <= hi && (in_0 || in_1 || in_2);
        return masked_root<V>(solve_piece<V>(k, a, b, fb > fa, hit), hit);
    }
}

template <int Degree, class V>
inline RootLanes<V> nearest_root(const PolynomialLanes<V>& k, const V& guess, const V& lo,
                                 const V& hi, const typename V::mask_type& active) {
    if constexpr (Degree <= 1) {
        const V t = -k[0] / k[1];
        return masked_root<V>(t, active && t >= lo && t <= hi);
    } else if constexpr (Degree == 2) {
        const RootPair<V> roots = quadratic_pair(k[0], k[1], k[2]);
        const auto near_in = roots.near >= lo && roots.near <= hi;
        const auto far_in = roots.far >= lo && roots.far <= hi;
        const auto near_wins = stdx::abs(roots.near - guess) <= stdx::abs(roots.far - guess);
        return masked_root<V>(select<V>(near_in && (near_wins || !far_in), roots.near, roots.far),
                              active && (near_in || far_in));
    } else {
        const CubicPieces<V> p = cut_cubic<V>(k, lo, hi);
        V best(0.0f);
        V gap(std::numeric_limits<float>::infinity());
        for (std::size_t i = 0; i < 3; ++i) {
            const auto has = active && p.has_root(i);
            if (stdx::none_of(has)) continue;
            const V t = solve_piece<V>(k, p.t[i], p.t[i + 1], p.f[i + 1] > p.f[i], has);
            const auto closer = has && stdx::abs(t - guess) < gap;
            gap = select<V>(closer, stdx::abs(t - guess), gap);
            best = select<V>(closer, t, best);
        }
        return {best, gap < std::numeric_limits<float>::infinity()};
    }
}

/// Every root in [lo, hi], in up to Degree lanes-wide candidates;
/// in ascending order where there are several.
template <class V>
struct RootCandidates {
    std::array<RootLanes<V>, 3> root;
    std::size_t n = 0;
};

template <int Degree, class V>
inline RootCandidates<V> all_roots(const PolynomialLanes<V>& k, const V& lo, const V& hi,
                                   const typename V::mask_type& active) {
    RootCandidates<V> out;
    const auto add = [&](const V& t, const typename V::mask_type& hit) {
        out.root[out.n++] = masked_root<V>(t, hit);
    };
    if constexpr (Degree <= 1) {
        const V t = -k[0] / k[1];
        add(t, active && t >= lo && t <= hi);
    } else if constexpr (Degree == 2) {
        const RootPair<V> roots = quadratic_pair(k[0], k[1], k[2]);
        add(roots.near, active && roots.near >= lo && roots.near <= hi);
        add(roots.far, active && roots.far >= lo && roots.far <= hi);
    } else {
        const CubicPieces<V> p = cut_cubic<V>(k, lo, hi);
        for (std::size_t i = 0; i < 3; ++i) {
            const auto has = active && lo <= hi && p.has_root(i);
            add(solve_piece<V>(k, p.t[i], p.t[i + 1], p.f[i + 1] > p.f[i], has), has);
        }
    }
    return out;
}

}  // namespace slim
