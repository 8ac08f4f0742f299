#pragma once

#include "slim/base/frame.h"
#include "slim/base/vec.h"

#include <array>
#include <cmath>

namespace slim {

/// Curvatures of a level set, 1 / length; convex is positive (a sphere of radius r: k1 = k2 = 1 / r).
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

}  // namespace slim
