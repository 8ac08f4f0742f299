#pragma once

#include "slim/base/simd.h"

#include <array>

namespace slim {

template <class V>
struct CurvatureLanes {
    V k1, k2, mean, gauss;
};

/// Lanes of curvature_from in slim/blend/curvature.h: the shape operator in the tangent basis of
/// Duff et al. (JCGT 2017). h is xx, xy, xz, yy, yz, zz, in the axes of the gradient.
template <class V>
inline CurvatureLanes<V> curvature_lanes(const V& gx, const V& gy, const V& gz,
                                         const std::array<V, 6>& h) {
    const V inv_len = 1.0f / stdx::sqrt(gx * gx + gy * gy + gz * gz);
    const V nx = gx * inv_len, ny = gy * inv_len, nz = gz * inv_len;
    const V sign = stdx::copysign(V(1.0f), nz);
    const V a = -1.0f / (sign + nz);
    const V b = nx * ny * a;
    const V ux = 1.0f + sign * nx * nx * a, uy = sign * b, uz = -sign * nx;
    const V vx = b, vy = sign + ny * ny * a, vz = -ny;
    const V hux = h[0] * ux + h[1] * uy + h[2] * uz;
    const V huy = h[1] * ux + h[3] * uy + h[4] * uz;
    const V huz = h[2] * ux + h[4] * uy + h[5] * uz;
    const V hvx = h[0] * vx + h[1] * vy + h[2] * vz;
    const V hvy = h[1] * vx + h[3] * vy + h[4] * vz;
    const V hvz = h[2] * vx + h[4] * vy + h[5] * vz;
    const V s11 = (ux * hux + uy * huy + uz * huz) * inv_len;
    const V s12 = (ux * hvx + uy * hvy + uz * hvz) * inv_len;
    const V s22 = (vx * hvx + vy * hvy + vz * hvz) * inv_len;
    const V mean = 0.5f * (s11 + s22), half = 0.5f * (s11 - s22);
    const V spread = stdx::sqrt(half * half + s12 * s12);
    return {mean + spread, mean - spread, mean, s11 * s22 - s12 * s12};
}

}  // namespace slim
