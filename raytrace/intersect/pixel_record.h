#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace slim {

/// A smooth surfel as a function of the pixel (project/notes/0001): with s = base_x + (x - pixel_x) step, t likewise
/// in y, the ray of a pixel passes q = (1 + kappa tau) (s, t, 0) + tau D in units of rho about the centre, camera axes, D
/// the centre's own ray (X, Y, 1), at camera z = z_center + rho tau. (s, t) is the offset at the centre's depth: all is
/// of the order of 1 near the ball at any distance. So f along the ray (NUMERICS 4.1) and |q|^2 are polynomials
/// in (s, t, tau), worked out in doubles once a surfel; a row of pixels has t in common, and a pixel is left with
/// Degree products for each power of tau. Not for balls near the eye or far off the axis.
template <int Degree>
struct alignas(64) PixelRecord {
    static constexpr std::size_t kPowers = Degree < 2 ? 3 : Degree + 1;  ///< of t
    static constexpr std::size_t kWidth = 16;
    static constexpr std::size_t kBall = static_cast<std::size_t>(Degree) * (Degree + 1);
    static constexpr std::size_t kGradient = kBall + 3;
    static_assert(kBall + 3 <= kWidth && (Degree != 2 || kGradient + 6 <= kWidth));

    float pixel_x, pixel_y;    ///< whole numbers: x - pixel_x is exact
    float base_x, base_y, step;
    float radius, inv_radius;
    float kappa;               ///< rho over the centre's depth: q has (1 + kappa tau) (s, t)
    float u_tau, v_tau;        ///< u = u_tau tau + (1 + kappa tau) u_axis . (s, t, 0), v likewise
    std::array<float, 3> u_axis, v_axis, normal;  ///< camera axes
    std::array<float, 10> a;                      ///< the height field
    std::array<float, 3> ball_s, ball_ss;         ///< coefficients of s and s^2 in |q|^2, by powers of tau
    std::array<float, 4> top;                     ///< coefficient of s^Degree in f, by powers of tau
    std::array<float, 3> gradient_s;              ///< degree 2: coefficient of (1 + kappa tau) s in the gradient
    /// Coefficients of t^j of what a row shares: of s^i tau^k in f at k Degree + i (i < Degree), of |q|^2
    /// by powers of tau from kBall on; for degree 2 from kGradient on the gradient's parts without tau and with it.
    std::array<std::array<float, kWidth>, kPowers> row;
};

}  // namespace slim
