#pragma once

#include "slim/base/frame.h"
#include "slim/fit/ball_points.h"
#include "slim/fit/lane_moments.h"
#include "slim/model/polynomial.h"
#include "slim/model/weight_kernel.h"

#include <array>

namespace slim {

/// Weighted sums of a height-field fit of one degree, coordinates divided by the gather radius:
/// A = sum G phi phi^T holds only the monomials up to twice the degree (NUMERICS 2.2).
template <int Degree>
struct Moments {
    static constexpr int kBasis = n_coefficients(Degree);
    static constexpr int kMonomials = n_coefficients(2 * Degree);
    std::array<double, kMonomials> monomial{};  ///< sum G u^a v^b, basis order continued
    std::array<double, kBasis> height{};        ///< sum G w phi
    double sq_height = 0;                       ///< sum G w^2
    double sq_weight = 0;                       ///< sum G^2

    double weight() const { return monomial[0]; }
    double n_effective() const {
        return sq_weight > 0 ? weight() * weight() / sq_weight : 0;
    }
};

/// Sums over the ball's points with weights G at |x| / shrink, shrink <= 1 being the fit's radius
/// over the gather radius. Products in T, lanes emptied into doubles every 16 groups.
template <int Degree, class T>
[[gnu::flatten]] Moments<Degree> accumulate_moments(const BallPoints<T>& points,
                                                    const Frame<double>& frame, double shrink) {
    using V = stdx::native_simd<T>;
    const auto axis = [](const Vec3d& a) { return Vec3<V>{V(T(a.x)), V(T(a.y)), V(T(a.z))}; };
    const Vec3<V> eu = axis(frame.u_axis), ev = axis(frame.v_axis), en = axis(frame.normal);
    const V to_fit = V(T(1 / (shrink * shrink)));
    Moments<Degree> sums;
    LaneMoments<Degree, V> lanes;
    for (std::size_t i = 0; i < points.padded(); i += V::size()) {
        const V x(&points.x[i], stdx::element_aligned), y(&points.y[i], stdx::element_aligned),
            z(&points.z[i], stdx::element_aligned), sq(&points.sq[i], stdx::element_aligned);
        const V g = fit_weight(points.weight, sq * to_fit);
        lanes.add(g, eu.x * x + eu.y * y + eu.z * z, ev.x * x + ev.y * y + ev.z * z,
                  en.x * x + en.y * y + en.z * z);
        if (lanes.is_full()) lanes.flush(sums);
    }
    lanes.flush(sums);
    return sums;
}

}  // namespace slim
