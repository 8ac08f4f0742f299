#pragma once

#include "raytrace/intersect/root_kernel.h"
#include "slim/base/simd.h"
#include "slim/model/height_hessian.h"

#include <array>
#include <cstdint>

namespace slim {

/// A surfel made ready for one view: floats relative to the centre and over rho, camera axes (x
/// right, y down, z along the view). Two cache lines.
///
/// The ray of pixel (x, y) passes b0 = (base_x + (x - pixel_x) step, base_y + (y - pixel_y) step,
/// base_z): its point at depth z_base. Everything is O(1) near the ball, so float is safe at any
/// distance (NUMERICS 4.1); x - pixel_x is exact.
struct alignas(64) DrawRecord {
    float pixel_x, pixel_y;
    float base_x, base_y, base_z;
    float step;
    float radius, inv_radius;
    std::array<float, 3> u_axis, v_axis, normal;
    std::array<float, 10> a;
    std::uint32_t node;
    double z_base;    ///< camera z of b0
    double z_center;  ///< camera z of the ball's centre
};
static_assert(sizeof(DrawRecord) == 128);

/// Rays through some pixels of one row: unit directions in camera axes.
template <class V>
struct PixelRays {
    V x, y;        ///< pixel indices
    V dx, dy, dz;
    V inv_dz;
};

/// The part of the set-up that the tests against the ball need.
template <class V>
struct BallRay {
    V x0, y0;       ///< b0; its z is base_z
    V along;        ///< b0 . d
    V px, py, pz;   ///< closest point to the centre
    V sq_distance;  ///< its squared distance

    V sq_distance_at(const DrawRecord& r, const PixelRays<V>& rays, const V& tau) const {
        const V x = x0 + tau * rays.dx, y = y0 + tau * rays.dy, z = r.base_z + tau * rays.dz;
        return x * x + y * y + z * z;
    }
};

template <class V>
inline BallRay<V> ball_ray(const DrawRecord& r, const PixelRays<V>& rays) {
    BallRay<V> b;
    b.x0 = (rays.x - r.pixel_x) * r.step + r.base_x;
    b.y0 = (rays.y - r.pixel_y) * r.step + r.base_y;
    b.along = b.x0 * rays.dx + b.y0 * rays.dy + r.base_z * rays.dz;
    b.px = b.x0 - b.along * rays.dx;
    b.py = b.y0 - b.along * rays.dy;
    b.pz = r.base_z - b.along * rays.dz;
    b.sq_distance = b.px * b.px + b.py * b.py + b.pz * b.pz;
    return b;
}

/// The ray in the surfel's own axes: base + t direction.
template <class V>
struct SurfelRay {
    V bu, bv, bw, du, dv, dw;
};

template <class V>
inline V dot_axis(const std::array<float, 3>& axis, const V& x, const V& y, const V& z) {
    return axis[0] * x + axis[1] * y + axis[2] * z;
}

template <class V, class Record>
inline SurfelRay<V> surfel_ray(const Record& r, const PixelRays<V>& rays, const BallRay<V>& b) {
    return {dot_axis(r.u_axis, b.px, b.py, b.pz),
            dot_axis(r.v_axis, b.px, b.py, b.pz),
            dot_axis(r.normal, b.px, b.py, b.pz),
            dot_axis(r.u_axis, rays.dx, rays.dy, rays.dz),
            dot_axis(r.v_axis, rays.dx, rays.dy, rays.dz),
            dot_axis(r.normal, rays.dx, rays.dy, rays.dz)};
}

/// Slopes of the height field at (u, v). Degree 1 records have none: their normal is turned.
template <int Degree, class V, class Record>
[[gnu::always_inline]] inline void slopes(const Record& r, const V& u, const V& v, V& p_u, V& p_v) {
    const auto& a = r.a;
    if constexpr (Degree <= 1) {
        p_u = V(0.0f), p_v = V(0.0f);
    } else if constexpr (Degree == 2) {
        p_u = a[1] + 2.0f * a[3] * u + a[4] * v;
        p_v = a[2] + 2.0f * a[5] * v + a[4] * u;
    } else {
        p_u = a[1] + u * (2.0f * a[3] + u * (3.0f * a[6])) +
              v * (a[4] + (2.0f * a[7]) * u + a[8] * v);
        p_v = a[2] + v * (2.0f * a[5] + v * (3.0f * a[9])) +
              u * (a[4] + a[7] * u + (2.0f * a[8]) * v);
    }
}

/// f = w - P along the ray (NUMERICS 4.1).
template <int Degree, class V, class Record>
[[gnu::always_inline]] inline PolynomialLanes<V> ray_polynomial(const Record& r,
                                                                const SurfelRay<V>& s) {
    const auto& a = r.a;
    const V &u = s.bu, &v = s.bv, &du = s.du, &dv = s.dv;
    if constexpr (Degree <= 1) {
        return {s.bw - a[0], s.dw, V(0.0f), V(0.0f)};
    } else {
        V p_u, p_v;
        slopes<Degree, V>(r, u, v, p_u, p_v);
        const V k1 = s.dw - (p_u * du + p_v * dv);
        if constexpr (Degree == 2) {
            const V height = a[0] + u * (a[1] + u * a[3]) + v * (a[2] + v * a[5] + u * a[4]);
            return {s.bw - height, k1, -(du * (a[3] * du + a[4] * dv) + a[5] * dv * dv), V(0.0f)};
        } else {
            const V height = a[0] + u * (a[1] + u * (a[3] + u * a[6])) +
                             v * (a[2] + v * (a[5] + v * a[9]) + u * (a[4] + u * a[7] + v * a[8]));
            const V half_uu = a[3] + 3.0f * a[6] * u + a[7] * v;
            const V uv = a[4] + 2.0f * (a[7] * u + a[8] * v);
            const V half_vv = a[5] + 3.0f * a[9] * v + a[8] * u;
            const V third = du * du * (a[6] * du + a[7] * dv) + dv * dv * (a[8] * du + a[9] * dv);
            return {s.bw - height, k1, -(du * (half_uu * du + uv * dv) + half_vv * dv * dv),
                    -third};
        }
    }
}

/// Gradient of f times rho, camera axes.
template <class V>
struct GradientLanes {
    V x, y, z;
};

template <int Degree, class V, class Record>
[[gnu::always_inline]] inline GradientLanes<V> gradient_at(const Record& r, const V& u,
                                                           const V& v) {
    if constexpr (Degree <= 1) {
        return {V(r.normal[0]), V(r.normal[1]), V(r.normal[2])};
    } else {
        V p_u, p_v;
        slopes<Degree, V>(r, u, v, p_u, p_v);
        return {r.normal[0] - r.u_axis[0] * p_u - r.v_axis[0] * p_v,
                r.normal[1] - r.u_axis[1] * p_u - r.v_axis[1] * p_v,
                r.normal[2] - r.u_axis[2] * p_u - r.v_axis[2] * p_v};
    }
}

/// P_uu, P_uv, P_vv of the height field at (u, v).
template <int Degree, class V, class Record>
[[gnu::always_inline]] inline std::array<V, 3> second_derivatives(const Record& r, const V& u,
                                                                  const V& v) {
    const auto& a = r.a;
    if constexpr (Degree < 3) {
        return {V(2 * a[3]), V(a[4]), V(2 * a[5])};
    } else {
        return {2.0f * a[3] + 6.0f * a[6] * u + 2.0f * a[7] * v,
                a[4] + 2.0f * a[7] * u + 2.0f * a[8] * v,
                2.0f * a[5] + 6.0f * a[9] * v + 2.0f * a[8] * u};
    }
}

/// Hessian of f times rho, camera axes: xx, xy, xz, yy, yz, zz (NUMERICS 5.1). p: P_uu, P_uv, P_vv.
template <class V, class Record>
[[gnu::always_inline]] inline std::array<V, 6> hessian_from(const Record& r,
                                                            const std::array<V, 3>& p) {
    const float scale = -r.inv_radius;
    const V uu = scale * p[0], uv = scale * p[1], vv = scale * p[2];
    const auto &e = r.u_axis, &f = r.v_axis;
    std::array<V, 3> a, b;
    for (std::size_t i = 0; i < 3; ++i) {
        a[i] = e[i] * uu + f[i] * uv;
        b[i] = e[i] * uv + f[i] * vv;
    }
    return {a[0] * e[0] + b[0] * f[0], a[0] * e[1] + b[0] * f[1], a[0] * e[2] + b[0] * f[2],
            a[1] * e[1] + b[1] * f[1], a[1] * e[2] + b[1] * f[2], a[2] * e[2] + b[2] * f[2]};
}

/// Third derivatives of f times rho, camera axes: xxx, xxy, xxz, xyy, xyz, xzz, yyy, yyz, yzz, zzz.
/// The same everywhere on a cubic surfel (NUMERICS 5.1).
template <class Record>
inline std::array<float, 10> third_of(const Record& r) {
    const float scale = -r.inv_radius * r.inv_radius;
    const float uuu = scale * 6 * r.a[6], uuv = scale * 2 * r.a[7];
    const float uvv = scale * 2 * r.a[8], vvv = scale * 6 * r.a[9];
    const auto &e = r.u_axis, &f = r.v_axis;
    std::array<float, 10> out;
    std::size_t at = 0;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = i; j < 3; ++j) {
            const float ee = e[i] * e[j], ef = e[i] * f[j] + f[i] * e[j], ff = f[i] * f[j];
            const float along_u = uuu * ee + uuv * ef + uvv * ff;
            const float along_v = uuv * ee + uvv * ef + vvv * ff;
            for (std::size_t k = j; k < 3; ++k) out[at++] = along_u * e[k] + along_v * f[k];
        }
    return out;
}

/// What the sums of a surfel's second derivatives need of it.
struct HessianRecord {
    HeightHessian p;
    std::array<float, 3> u_axis, v_axis;
    float inv_radius;
};

}  // namespace slim
