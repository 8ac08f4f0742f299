#pragma once

#include "slim/fit/moments.h"

namespace slim {

/// Weighted sums of the slopes that the normals of a ball's points give a height field, coordinates
/// divided by the gather radius. With Moments they make the normal equations of a fit to points and
/// normals.
template <int Degree>
struct SlopeMoments {
    static constexpr int kBasis = n_coefficients(Degree - 1);
    std::array<double, kBasis> along_u{}, along_v{};  ///< sum G s_u phi, sum G s_v phi
    double sq_slope = 0;                              ///< sum G (s_u^2 + s_v^2)
    double weight = 0;                                ///< sum G of the points that have a slope
};

/// Sums over the points whose normal n is within the height field: s = (-n_u / n_w, -n_v / n_w).
/// Weights as in accumulate_moments.
template <int Degree, class T>
SlopeMoments<Degree> accumulate_slopes(const BallPoints<T>& points, const Frame<double>& frame,
                                       double shrink, T least_cos) {
    using V = stdx::native_simd<T>;
    using Sums = SlopeMoments<Degree>;
    const auto axis = [](const Vec3d& a) { return Vec3<V>{V(T(a.x)), V(T(a.y)), V(T(a.z))}; };
    const Vec3<V> eu = axis(frame.u_axis), ev = axis(frame.v_axis), en = axis(frame.normal);
    const V to_fit = V(T(1 / (shrink * shrink)));
    Sums sums;
    for (std::size_t i = 0; i < points.padded();) {
        std::array<V, Sums::kBasis> along_u{}, along_v{};
        V sq_slope{}, weight{};
        for (int group = 0; group < 16 && i < points.padded(); ++group, i += V::size()) {
            const auto lanes = [&](const auto& a) { return V(&a[i], stdx::element_aligned); };
            const V x = lanes(points.x), y = lanes(points.y), z = lanes(points.z);
            const V nx = lanes(points.nx), ny = lanes(points.ny), nz = lanes(points.nz);
            const V nw = en.x * nx + en.y * ny + en.z * nz;
            const auto faces = nw > least_cos;
            const V g =
                select(faces, fit_weight(points.weight, lanes(points.sq) * to_fit), V(T(0)));
            const V down = V(T(-1)) / select(faces, nw, V(T(1)));
            const V su = (eu.x * nx + eu.y * ny + eu.z * nz) * down;
            const V sv = (ev.x * nx + ev.y * ny + ev.z * nz) * down;
            const V u = eu.x * x + eu.y * y + eu.z * z, v = ev.x * x + ev.y * y + ev.z * z;
            std::array<V, Sums::kBasis> m;
            m[0] = g;
            std::size_t below = 0, at = 1;
            for (std::size_t d = 1; d < Degree; ++d) {
                for (std::size_t t = 0; t < d; ++t) m[at++] = m[below + t] * u;
                m[at] = m[at - d - 1] * v;
                ++at;
                below += d;
            }
            for (std::size_t k = 0; k < m.size(); ++k)
                along_u[k] += m[k] * su, along_v[k] += m[k] * sv;
            sq_slope += g * (su * su + sv * sv);
            weight += g;
        }
        for (std::size_t k = 0; k < along_u.size(); ++k) {
            sums.along_u[k] += lane_sum(along_u[k]);
            sums.along_v[k] += lane_sum(along_v[k]);
        }
        sums.sq_slope += lane_sum(sq_slope);
        sums.weight += lane_sum(weight);
    }
    return sums;
}

}  // namespace slim
