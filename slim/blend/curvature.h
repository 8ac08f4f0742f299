#pragma once

#include "slim/base/frame.h"
#include "slim/base/vec.h"

#include <array>
#include <cmath>

namespace slim {

/// Curvatures of a level set, 1 / length; convex is positive (a sphere of radius r:
/// k1 = k2 = 1 / r).
struct Curvature {
    double k1 = 0, k2 = 0;  ///< k1 >= k2
    double mean = 0, gauss = 0;
};

/// Symmetric 3x3 matrix: xx, xy, xz, yy, yz, zz.
using SymmetricMatrix = std::array<double, 6>;

inline Vec3d times(const SymmetricMatrix& h, const Vec3d& a) {
    return {h[0] * a.x + h[1] * a.y + h[2] * a.z, h[1] * a.x + h[3] * a.y + h[4] * a.z,
            h[2] * a.x + h[4] * a.y + h[5] * a.z};
}

/// Curvatures from gradient and Hessian of an implicit function, both to any common scale
/// (NUMERICS 5.2): the shape operator in a tangent basis, so that k1 and k2 come without the
/// cancellation of mean^2 - Gauss. A zero gradient gives NaN.
inline Curvature curvature_from(const Vec3d& gradient, const SymmetricMatrix& hessian) {
    const double len = length(gradient);
    const Frame<double> tangent = frame_from_normal(gradient / len);
    const Vec3d hu = times(hessian, tangent.u_axis), hv = times(hessian, tangent.v_axis);
    const double s11 = dot(tangent.u_axis, hu) / len;
    const double s12 = dot(tangent.u_axis, hv) / len;
    const double s22 = dot(tangent.v_axis, hv) / len;
    const double mean = 0.5 * (s11 + s22);
    const double spread = std::hypot(0.5 * (s11 - s22), s12);
    return {mean + spread, mean - spread, mean, s11 * s22 - s12 * s12};
}

/// Symmetric 3x3x3 tensor: xxx, xxy, xxz, xyy, xyz, xzz, yyy, yyz, yzz, zzz.
using SymmetricTensor = std::array<double, 10>;

/// The tensor with its last place taken by a: C(., ., a).
inline SymmetricMatrix times(const SymmetricTensor& c, const Vec3d& a) {
    return {c[0] * a.x + c[1] * a.y + c[2] * a.z, c[1] * a.x + c[3] * a.y + c[4] * a.z,
            c[2] * a.x + c[4] * a.y + c[5] * a.z, c[3] * a.x + c[6] * a.y + c[7] * a.z,
            c[4] * a.x + c[7] * a.y + c[8] * a.z, c[5] * a.x + c[8] * a.y + c[9] * a.z};
}

/// Principal directions and what the principal curvatures do along them (NUMERICS 5.3). Signs of e1
/// and k1_along_t2, and of the others, go with the arbitrary sign of t1 and t2 = N x t1.
struct ThirdOrder {
    Vec3d t1, t2;
    double e1 = 0;           ///< dk1 / dt1, 1 / length^2
    double k1_along_t2 = 0;
    double k2_along_t1 = 0;
    double e2 = 0;           ///< dk2 / dt2
};

/// From gradient, Hessian and third derivatives of an implicit function, all to one scale (NUMERICS
/// 5.3: Q(a, b, c) = [C(a, b, c) - S(a, b) h.c - S(b, c) h.a - S(c, a) h.b] / |g|, h = P H N).
/// Where k1 = k2 the directions are any. A zero gradient gives NaN.
inline ThirdOrder third_order_from(const Vec3d& gradient, const SymmetricMatrix& hessian,
                                   const SymmetricTensor& third) {
    const double len = length(gradient);
    const Vec3d normal = gradient / len;
    const Frame<double> tangent = frame_from_normal(normal);
    const Vec3d &u = tangent.u_axis, &v = tangent.v_axis;
    const Vec3d hu = times(hessian, u), hv = times(hessian, v);
    const double angle = 0.5 * std::atan2(2 * dot(u, hv), dot(u, hu) - dot(v, hv));
    ThirdOrder out;
    out.t1 = u * std::cos(angle) + v * std::sin(angle);
    out.t2 = cross(normal, out.t1);
    const Curvature k = curvature_from(gradient, hessian);
    const Vec3d hn = times(hessian, normal);
    const double h1 = dot(hn, out.t1), h2 = dot(hn, out.t2);
    const Vec3d c11 = times(times(third, out.t1), out.t1),
                c22 = times(times(third, out.t2), out.t2);
    out.e1 = (dot(c11, out.t1) - 3 * k.k1 * h1) / len;
    out.k1_along_t2 = (dot(c11, out.t2) - k.k1 * h2) / len;
    out.k2_along_t1 = (dot(c22, out.t1) - k.k2 * h1) / len;
    out.e2 = (dot(c22, out.t2) - 3 * k.k2 * h2) / len;
    return out;
}

}  // namespace slim
