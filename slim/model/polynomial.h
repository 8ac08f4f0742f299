#pragma once

#include <array>
#include <cstddef>

namespace slim {

inline constexpr int kMaxDegree = 3;
inline constexpr int kMaxCoefficients = 10;

/// K = 3, 6, 10 for degree 1, 2, 3; 1 for a disc (degree 0).
constexpr int n_coefficients(int degree) { return (degree + 1) * (degree + 2) / 2; }

/// Height field w = P(u, v), basis by degree: 1, u, v, u^2, uv, v^2, u^3, u^2 v, u v^2, v^3, in
/// coordinates relative to the centre and divided by the support radius.
/// Coefficients beyond the degree are zero.
template <class T>
struct Polynomial {
    std::array<T, kMaxCoefficients> a{};

    T value(T u, T v) const {
        return a[0] + u * (a[1] + u * (a[3] + u * a[6])) +
               v * (a[2] + v * (a[5] + v * a[9]) + u * (a[4] + u * a[7] + v * a[8]));
    }
    T d_u(T u, T v) const {
        return a[1] + u * (T(2) * a[3] + u * T(3) * a[6]) + v * (a[4] + T(2) * u * a[7] + v * a[8]);
    }
    T d_v(T u, T v) const {
        return a[2] + v * (T(2) * a[5] + v * T(3) * a[9]) + u * (a[4] + u * a[7] + T(2) * v * a[8]);
    }
    T d_uu(T u, T v) const { return T(2) * (a[3] + T(3) * u * a[6] + v * a[7]); }
    T d_uv(T u, T v) const { return a[4] + T(2) * (u * a[7] + v * a[8]); }
    T d_vv(T u, T v) const { return T(2) * (a[5] + T(3) * v * a[9] + u * a[8]); }
    /// P_uuu, P_uuv, P_uvv, P_vvv: the same everywhere.
    std::array<T, 4> third() const { return {T(6) * a[6], T(2) * a[7], T(2) * a[8], T(6) * a[9]}; }
};

/// The same height field in coordinates over `ratio` times the radius:
/// terms of degree d times ratio^(d - 1).
template <class T>
Polynomial<T> rescaled(const Polynomial<T>& p, T ratio) {
    Polynomial<T> out;
    T factor = T(1) / ratio;
    for (int degree = 0, k = 0; degree <= kMaxDegree; ++degree, factor *= ratio)
        for (; k < n_coefficients(degree); ++k)
            out.a[static_cast<std::size_t>(k)] = p.a[static_cast<std::size_t>(k)] * factor;
    return out;
}

}  // namespace slim
