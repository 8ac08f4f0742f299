#pragma once

#include "slim/base/vec.h"

#include <cmath>

namespace slim {

/// Orthonormal right-handed basis: world = u_axis * u + v_axis * v + normal * w.
template <class T>
struct Frame {
    Vec3<T> u_axis, v_axis, normal;

    Vec3<T> local_from_world(const Vec3<T>& d) const {
        return {dot(u_axis, d), dot(v_axis, d), dot(normal, d)};
    }
    Vec3<T> world_from_local(const Vec3<T>& d) const {
        return u_axis * d.x + v_axis * d.y + normal * d.z;
    }
};

/// Completes a unit normal to a frame by the one branchless formula of Duff et al., "Building an
/// Orthonormal Basis, Revisited" (JCGT 2017), so that a stored normal alone fixes the frame
/// (NUMERICS 2.1).
template <class T>
Frame<T> frame_from_normal(const Vec3<T>& n) {
    const T sign = std::copysign(T(1), n.z);
    const T a = T(-1) / (sign + n.z);
    const T b = n.x * n.y * a;
    return {{T(1) + sign * n.x * n.x * a, sign * b, -sign * n.x},
            {b, sign + n.y * n.y * a, -n.y},
            n};
}

/// Octahedral map of a unit vector to [-1, 1]^2 and back (Meyer et al. 2010); two floats, multiples
/// of 2^-24, keep the direction to about 1e-7 rad.
struct Octahedral {
    float s = 0, t = 0;
};

/// Rounds to a multiple of 2^-24, the step of floats below 1. On this grid 1 - |s| - |t| is exact
/// and either 0 or far above rounding: a normal read back gives the same two floats again, and
/// beside the fold at n.z = 0 the frame never turns. Finer floats near 0 would not keep that.
inline float round_to_grid(double x) {
    return static_cast<float>(std::nearbyint(x * 0x1p24) * 0x1p-24);
}

inline Octahedral octahedral_from_normal(const Vec3d& n) {
    const double l1 = std::abs(n.x) + std::abs(n.y) + std::abs(n.z);
    double s = n.x / l1, t = n.y / l1;
    if (n.z < 0) {
        const double s0 = s;
        s = (1 - std::abs(t)) * std::copysign(1.0, s0);
        t = (1 - std::abs(s0)) * std::copysign(1.0, t);
    }
    return {round_to_grid(s), round_to_grid(t)};
}

inline Vec3d normal_from_octahedral(const Octahedral& o) {
    double s = o.s, t = o.t;
    const double w = 1 - std::abs(s) - std::abs(t);
    if (w < 0) {
        const double s0 = s;
        s = (1 - std::abs(t)) * std::copysign(1.0, s0);
        t = (1 - std::abs(s0)) * std::copysign(1.0, t);
    }
    return normalized(Vec3d{s, t, w});
}

}  // namespace slim
