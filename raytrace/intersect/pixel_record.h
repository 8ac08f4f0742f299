#pragma once

#include <array>
#include <cstddef>

namespace slim {

/// Number of coefficients of a polynomial of some degree in two variables: by degree 1, s, t, s^2,
/// st, t^2, ...
constexpr std::size_t n_planar(int degree) {
    return static_cast<std::size_t>((degree + 1) * (degree + 2) / 2);
}
/// Where the power p of tau begins in PixelRecord::f.
constexpr std::size_t power_start(int degree, int p) {
    return p == 0 ? 0 : power_start(degree, p - 1) + n_planar(degree - p + 1);
}

/// A smooth surfel as a function of the pixel and of depth (project/notes/0002). In units of rho
/// about the centre, camera axes, the ray of a pixel passes q = Q / h with Q = (s, t, 0) + tau (X,
/// Y, 1), h = 1 - kappa tau: (s, t) is the ray's offset at the centre's depth, (X, Y, 1) the
/// centre's own ray, kappa rho over the centre's depth, and tau = (z - z_c) / rho z_c / z, in
/// orthographic views kappa = 0. As Q and h are linear in (s, t, tau), h^Degree f is a polynomial
/// of degree Degree in all three, and h^2 (|q|^2 - R^2) one of degree 2. All are of the order of 1
/// near the ball at any distance. Not for balls near the eye or far off the axis. F: float, or
/// lanes of some surfels.
template <int Degree, class F = float>
struct alignas(64) PixelRecord {
    F pixel_x, pixel_y;  ///< whole numbers: x - pixel_x is exact
    F base_x, base_y, step;  ///< s = base_x + (x - pixel_x) step, t likewise in y
    F radius, inv_radius, kappa;
    F ball_s, ball_t, ball_tau;  ///< |Q|^2 = s^2 + t^2 + tau (ball_s s + ball_t t) + ball_tau tau^2
    std::array<F, 3> u, v;       ///< of h u and h v: coefficients of s, t, tau
    /// h^Degree f: for each power p of tau n_planar(Degree - p) coefficients in s and t.
    std::array<F, power_start(Degree, Degree + 1)> f;
    /// Camera axes; degree 2 has its gradient instead, and needs no more of the height field.
    std::array<F, Degree == 2 ? 0 : 3> u_axis, v_axis, normal;
    /// Degree 2: h grad f rho, each component's coefficients of 1, s, t, tau.
    std::array<std::array<F, 4>, Degree == 2 ? 3 : 0> gradient;
    std::array<F, Degree == 2 ? 0 : 10> a;  ///< the height field
};

}  // namespace slim
