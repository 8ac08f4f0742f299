#pragma once

#include "slim/base/vec.h"

#include <array>
#include <cmath>

namespace slim {

/// A number with its first and second derivatives in x, y, z (second-order forward mode):
/// evaluating a formula on jets gives value, gradient and Hessian exactly, up to rounding.
struct Jet2 {
    double value = 0;
    std::array<double, 3> g{};  ///< d/dx, d/dy, d/dz
    std::array<double, 6> h{};  ///< xx, xy, xz, yy, yz, zz

    Jet2() = default;
    Jet2(double constant) : value(constant) {}  // NOLINT: a constant is a jet

    /// The coordinate `axis` (0, 1, 2) at `at`.
    static Jet2 variable(double at, std::size_t axis) {
        Jet2 j(at);
        j.g[axis] = 1;
        return j;
    }

    Vec3d gradient() const { return {g[0], g[1], g[2]}; }
    /// Hessian times a vector.
    Vec3d hessian_times(const Vec3d& v) const {
        return {h[0] * v.x + h[1] * v.y + h[2] * v.z, h[1] * v.x + h[3] * v.y + h[4] * v.z,
                h[2] * v.x + h[4] * v.y + h[5] * v.z};
    }
};

namespace jet_detail {

/// Entry (i, j) of the packed Hessian.
inline constexpr std::array<std::array<std::size_t, 2>, 6> kPairs{
    {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};

}  // namespace jet_detail

/// f(a) from f, f', f'' at a.value (chain rule).
inline Jet2 chain(const Jet2& a, double f, double f1, double f2) {
    Jet2 r(f);
    for (std::size_t i = 0; i < 3; ++i) r.g[i] = f1 * a.g[i];
    for (std::size_t k = 0; k < 6; ++k) {
        const auto [i, j] = jet_detail::kPairs[k];
        r.h[k] = f1 * a.h[k] + f2 * a.g[i] * a.g[j];
    }
    return r;
}

inline Jet2 operator-(const Jet2& a) { return chain(a, -a.value, -1, 0); }

inline Jet2 operator+(const Jet2& a, const Jet2& b) {
    Jet2 r(a.value + b.value);
    for (std::size_t i = 0; i < 3; ++i) r.g[i] = a.g[i] + b.g[i];
    for (std::size_t k = 0; k < 6; ++k) r.h[k] = a.h[k] + b.h[k];
    return r;
}

inline Jet2 operator-(const Jet2& a, const Jet2& b) {
    Jet2 r(a.value - b.value);
    for (std::size_t i = 0; i < 3; ++i) r.g[i] = a.g[i] - b.g[i];
    for (std::size_t k = 0; k < 6; ++k) r.h[k] = a.h[k] - b.h[k];
    return r;
}

inline Jet2 operator*(const Jet2& a, const Jet2& b) {
    Jet2 r(a.value * b.value);
    for (std::size_t i = 0; i < 3; ++i) r.g[i] = a.value * b.g[i] + b.value * a.g[i];
    for (std::size_t k = 0; k < 6; ++k) {
        const auto [i, j] = jet_detail::kPairs[k];
        r.h[k] = a.value * b.h[k] + b.value * a.h[k] + a.g[i] * b.g[j] + a.g[j] * b.g[i];
    }
    return r;
}

inline Jet2 operator+(Jet2 a, double b) {
    a.value += b;
    return a;
}
inline Jet2 operator+(double a, const Jet2& b) { return b + a; }
inline Jet2 operator-(const Jet2& a, double b) { return a + (-b); }
inline Jet2 operator-(double a, const Jet2& b) { return a + (-b); }
inline Jet2 operator*(const Jet2& a, double s) { return chain(a, a.value * s, s, 0); }
inline Jet2 operator*(double s, const Jet2& a) { return a * s; }
inline Jet2 operator/(const Jet2& a, double s) { return a * (1 / s); }
inline Jet2 operator/(double a, const Jet2& b) {
    const double r = 1 / b.value;
    return chain(b, a * r, -a * r * r, 2 * a * r * r * r);
}
inline Jet2 operator/(const Jet2& a, const Jet2& b) { return a * (1.0 / b); }

inline Jet2 sqrt(const Jet2& a) {
    const double s = std::sqrt(a.value);
    return chain(a, s, 0.5 / s, -0.25 / (s * a.value));
}
inline Jet2 sin(const Jet2& a) {
    const double s = std::sin(a.value);
    return chain(a, s, std::cos(a.value), -s);
}
inline Jet2 cos(const Jet2& a) {
    const double c = std::cos(a.value);
    return chain(a, c, -std::sin(a.value), -c);
}
inline Jet2 exp(const Jet2& a) {
    const double e = std::exp(a.value);
    return chain(a, e, e, e);
}
inline Jet2 atan(const Jet2& a) {
    const double d = 1 / (1 + a.value * a.value);
    return chain(a, std::atan(a.value), d, -2 * a.value * d * d);
}
/// Angle of (x, y); any branch has the same derivatives, so the larger argument divides.
inline Jet2 atan2(const Jet2& y, const Jet2& x) {
    Jet2 r = std::abs(x.value) > std::abs(y.value) ? atan(y / x) : -atan(x / y);
    r.value = std::atan2(y.value, x.value);
    return r;
}

inline double value_of(double a) { return a; }
inline double value_of(const Jet2& a) { return a.value; }

}  // namespace slim
