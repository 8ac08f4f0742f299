#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace slim {

/// f(t) = k[0] + k[1] t + k[2] t^2 + k[3] t^3: a surfel's polynomial along a local ray, |t| <= 1.
template <class T>
using RayPolynomial = std::array<T, 4>;

template <class T>
T ray_value(const RayPolynomial<T>& k, T t) {
    return k[0] + t * (k[1] + t * (k[2] + t * k[3]));
}

/// Real roots inside an interval, ascending; at most three.
template <class T>
struct RootList {
    std::array<T, 3> t{};
    int n = 0;

    void add(T root, T lo, T hi) {
        if (root >= lo && root <= hi && n < 3) t[static_cast<std::size_t>(n++)] = root;
    }
    std::optional<T> first() const { return n > 0 ? std::optional<T>(t[0]) : std::nullopt; }
    std::optional<T> nearest(T to) const {
        std::optional<T> best;
        for (int i = 0; i < n; ++i) {
            const T root = t[static_cast<std::size_t>(i)];
            if (!best || std::abs(root - to) < std::abs(*best - to)) best = root;
        }
        return best;
    }
};

/// Roots of k0 + k1 t + k2 t^2 in [lo, hi] without cancellation (NUMERICS 4.2): the discriminant to
/// full precision by two fma (Kahan), the larger root by q, the other by the product of both. A
/// discriminant within 8 u k1^2 of zero is a tangent: one root.
template <class T>
RootList<T> quadratic_roots(T k0, T k1, T k2, T lo, T hi) {
    constexpr T u = std::numeric_limits<T>::epsilon() / 2;
    RootList<T> roots;
    const T w = 4 * k2 * k0;
    const T discriminant = std::fma(k1, k1, -w) + std::fma(-4 * k2, k0, w);
    if (k2 != 0 && std::abs(discriminant) < 8 * u * k1 * k1) {
        roots.add(-k1 / (2 * k2), lo, hi);
        return roots;
    }
    if (!(discriminant >= 0)) return roots;
    const T q = -(k1 + std::copysign(std::sqrt(discriminant), k1)) / 2;
    if (q == 0) {  // k1 = 0 and k0 k2 = 0: a double root at 0, or f is constant
        if (k2 != 0) roots.add(T(0), lo, hi);
        return roots;
    }
    const T by_product = k0 / q;
    if (k2 == 0) {
        roots.add(by_product, lo, hi);
        return roots;
    }
    roots.add(std::min(by_product, q / k2), lo, hi);
    roots.add(std::max(by_product, q / k2), lo, hi);
    return roots;
}

/// The root of f in [a, b] where f changes sign: Newton, with bisection as guard; stops at
/// |f| <= 4 u sum |k_i t^i|.
template <class T>
T bracketed_root(const RayPolynomial<T>& k, T a, T b) {
    constexpr T u = std::numeric_limits<T>::epsilon() / 2;
    const bool rising = ray_value(k, b) > 0;
    T t = (a + b) / 2;
    for (int i = 0; i < 100; ++i) {
        const T f = ray_value(k, t);
        const T x = std::abs(t);
        const T size = std::abs(k[0]) + x * (std::abs(k[1]) + x * (std::abs(k[2]) +
                                                                  x * std::abs(k[3])));
        if (std::abs(f) <= 4 * u * size) break;
        ((f > 0) == rising ? b : a) = t;
        const T slope = k[1] + t * (2 * k[2] + t * 3 * k[3]);
        const T step = t - f / slope;
        const T next = step > a && step < b ? step : (a + b) / 2;
        if (next == t) break;
        t = next;
    }
    return t;
}

/// Roots of the cubic k in [lo, hi]: the interval is cut at the real roots of f', each piece with a
/// change of sign holds one (NUMERICS 4.2; the textbook formula finds wrong roots in float). Where
/// f touches zero at a cut, within rounding, the cut is the root.
template <class T>
RootList<T> cubic_roots(const RayPolynomial<T>& k, T lo, T hi) {
    if (k[3] == 0) return quadratic_roots(k[0], k[1], k[2], lo, hi);
    constexpr T u = std::numeric_limits<T>::epsilon() / 2;
    const RootList<T> cuts = quadratic_roots(k[1], 2 * k[2], 3 * k[3], lo, hi);
    std::array<T, 4> t{lo, hi, hi, hi};
    for (int i = 0; i < cuts.n; ++i)
        t[static_cast<std::size_t>(i) + 1] = cuts.t[static_cast<std::size_t>(i)];
    RootList<T> roots;
    std::array<T, 4> f{};
    for (std::size_t i = 0; i < 4; ++i) {
        const T x = std::abs(t[i]);
        const T size = std::abs(k[0]) + x * (std::abs(k[1]) + x * (std::abs(k[2]) +
                                                                  x * std::abs(k[3])));
        f[i] = ray_value(k, t[i]);
        if (std::abs(f[i]) <= 4 * u * size) f[i] = 0;
    }
    for (std::size_t i = 0; i < 4; ++i) {
        if (f[i] == 0 && (i == 0 || t[i] != t[i - 1])) roots.add(t[i], lo, hi);
        if (i < 3 && f[i] * f[i + 1] < 0) roots.add(bracketed_root(k, t[i], t[i + 1]), lo, hi);
    }
    return roots;
}

/// All roots in [lo, hi], by the degree that the coefficients really have.
template <class T>
RootList<T> ray_roots(const RayPolynomial<T>& k, T lo, T hi) {
    return cubic_roots(k, lo, hi);
}

}  // namespace slim
