#pragma once

#include "slim/base/frame.h"
#include "slim/model/surfel.h"

#include <array>
#include <cmath>

namespace slim::test {

/// Derivatives of a height field w = P(u, v) at one place, in length units.
struct HeightJet {
    double u, v;                ///< first, dimensionless
    double uu, uv, vv;          ///< second, 1 / length
    double uuu, uuv, uvv, vvv;  ///< third, 1 / length^2
};

/// Curvatures and their derivatives along the principal directions, axes of the height field;
/// convex positive, k1 >= k2. Signs of the directions are arbitrary, and so are those of the
/// derivatives.
struct ThirdOrder {
    Vec3d normal, t1, t2;
    double k1, k2;
    double e1, e2;        ///< dk1/dt1, dk2/dt2
    double k1_t2, k2_t1;  ///< dk1/dt2, dk2/dt1
};

/// NUMERICS 5.2 and 5.3 with f = w - P: S = P H P / |g|, Q(a, b, c) = [C(a, b, c) - S(a, b) h.c -
/// S(b, c) h.a - S(c, a) h.b] / |g|.
inline ThirdOrder third_order(const HeightJet& p) {
    const Vec3d g{-p.u, -p.v, 1};
    const double len = length(g);
    ThirdOrder out;
    out.normal = g / len;
    const auto hess = [&](const Vec3d& a, const Vec3d& b) {
        return -(p.uu * a.x * b.x + p.uv * (a.x * b.y + a.y * b.x) + p.vv * a.y * b.y);
    };
    const Frame<double> f = frame_from_normal(out.normal);
    const double s11 = hess(f.u_axis, f.u_axis) / len, s12 = hess(f.u_axis, f.v_axis) / len,
                 s22 = hess(f.v_axis, f.v_axis) / len;
    const double mean = (s11 + s22) / 2, spread = std::hypot((s11 - s22) / 2, s12);
    const double angle = std::atan2(2 * s12, s11 - s22) / 2;
    out.k1 = mean + spread, out.k2 = mean - spread;
    out.t1 = f.u_axis * std::cos(angle) + f.v_axis * std::sin(angle);
    out.t2 = f.v_axis * std::cos(angle) - f.u_axis * std::sin(angle);
    const auto third = [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
        return -(p.uuu * a.x * b.x * c.x +
                 p.uuv * (a.x * b.x * c.y + a.x * b.y * c.x + a.y * b.x * c.x) +
                 p.uvv * (a.x * b.y * c.y + a.y * b.x * c.y + a.y * b.y * c.x) +
                 p.vvv * a.y * b.y * c.y);
    };
    const auto q = [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
        const auto h = [&](const Vec3d& d) { return hess(out.normal, d); };
        return (third(a, b, c) - hess(a, b) / len * h(c) - hess(b, c) / len * h(a) -
                hess(c, a) / len * h(b)) /
               len;
    };
    out.e1 = q(out.t1, out.t1, out.t1), out.e2 = q(out.t2, out.t2, out.t2);
    out.k1_t2 = q(out.t1, out.t1, out.t2), out.k2_t1 = q(out.t1, out.t2, out.t2);
    return out;
}

/// The derivatives of a surfel's height field at (u, v), its coordinates over rho.
inline HeightJet height_jet(const Surfel& s, double u, double v) {
    const auto& p = s.polynomial;
    const double r = s.support_radius;
    return {p.d_u(u, v),          p.d_v(u, v),          p.d_uu(u, v) / r,
            p.d_uv(u, v) / r,     p.d_vv(u, v) / r,     6 * p.a[6] / (r * r),
            2 * p.a[7] / (r * r), 2 * p.a[8] / (r * r), 6 * p.a[9] / (r * r)};
}

}  // namespace slim::test
