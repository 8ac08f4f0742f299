#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace slim {

/// A smooth surfel as a function of the pixel (project/notes/0001): with s = base_x + (x - pixel_x) step, t likewise
/// in y, the ray of a pixel passes q(tau) = q0 + tau D in units of rho about the centre, camera axes, q0 and D affine
/// in (s, t) and camera z = z_base + rho tau. So f along the ray (NUMERICS 4.1) and |q|^2 are polynomials in
/// (s, t, tau), worked out in doubles once a surfel; a row of pixels has t in common, and a pixel is left with
/// Degree products for each power of tau. In front of the eye by more than four radii (s, t) is the offset
/// at the centre's depth, so that all is O(1) near the ball at any distance; nearer it is the slope of the ray.
template <int Degree>
struct alignas(64) PixelRecord {
    static constexpr std::size_t kPowers = Degree < 2 ? 3 : Degree + 1;  ///< of t
    static constexpr std::size_t kWidth = 16;
    static constexpr std::size_t kBall = static_cast<std::size_t>(Degree) * (Degree + 1);
    static_assert(kBall + 3 <= kWidth);

    float pixel_x, pixel_y;    ///< whole numbers: x - pixel_x is exact
    float base_x, base_y, step;
    float radius, inv_radius;
    float reach;               ///< largest |tau| in the shrunken ball
    float kappa_0, kappa_1;    ///< the share kappa_0 + kappa_1 tau of (s, t) in q
    float u_0, u_1, v_0, v_1;  ///< u = u_0 + u_1 tau + kappa (u_axis . (s, t, 0)), v likewise
    std::array<float, 3> u_axis, v_axis, normal;  ///< camera axes
    std::array<float, 10> a;                      ///< the height field
    std::array<float, 3> ball_s, ball_ss;         ///< coefficients of s and s^2 in |q|^2, by powers of tau
    std::array<float, 4> top;                     ///< coefficient of s^Degree in f, by powers of tau
    /// Coefficients of t^j of what a row shares: of s^i tau^k in f at k Degree + i (i < Degree), of |q|^2
    /// by powers of tau from kBall on.
    std::array<std::array<float, kWidth>, kPowers> row;
};

}  // namespace slim
