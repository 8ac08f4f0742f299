#pragma once

#include "raytrace/camera.h"
#include "raytrace/frame.h"
#include "slim/blend/curvature.h"

#include <cmath>
#include <cstddef>
#include <utility>

namespace slim::test {

/// A camera on the +x axis that looks at the origin, z up, orthographic, `width` units across.
inline Camera camera_from_x(double width) {
    Camera camera;
    camera.eye = {10, 0, 0}, camera.target = {0, 0, 0}, camera.up = {0, 0, 1};
    camera.orthographic = true, camera.width = width;
    return camera;
}

/// The exact G-buffer of the ellipsoid x^2/a^2 + y^2/b^2 + z^2/c^2 = 1: f is quadratic, so that its
/// third derivatives are zero and those of the curvature come from its Hessian alone.
inline GBuffer ellipsoid_buffer(const Camera& camera, int size, const Vec3d& axes) {
    const PixelView view = pixel_view(camera, size, size);
    GBuffer out;
    out.reset(size, size, kAllChannels);
    const auto scaled = [&](const Vec3d& p) {
        return Vec3d{p.x / axes.x, p.y / axes.y, p.z / axes.z};
    };
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const Vec3d o = view.ray_origin(x + 0.5, y + 0.5),
                        d = view.ray_direction(x + 0.5, y + 0.5);
            const Vec3d so = scaled(o), sd = scaled(d);
            const double b = dot(so, sd), c = dot(so, so) - 1, a = dot(sd, sd);
            if (b * b < a * c) continue;
            const Vec3d p = o + d * ((-b - std::sqrt(b * b - a * c)) / a);
            const Vec3d g = scaled(scaled(p));
            const SymmetricMatrix h{1 / (axes.x * axes.x), 0, 0,
                                    1 / (axes.y * axes.y), 0, 1 / (axes.z * axes.z)};
            const Curvature k = curvature_from(g, h);
            const ThirdOrder t = third_order_from(g, h, {});
            const std::size_t i = out.index(x, y);
            const Vec3f q = to_float(p), n = to_float(normalized(g)), t1 = to_float(t.t1);
            out.hit[i] = 1;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                out.position[axis][i] = q[axis], out.normal[axis][i] = n[axis];
                out.direction[axis][i] = t1[axis];
            }
            out.k1[i] = static_cast<float>(k.k1), out.k2[i] = static_cast<float>(k.k2);
            out.gauss[i] = static_cast<float>(k.gauss);
            const double third[4] = {t.e1, t.k1_along_t2, t.k2_along_t1, t.e2};
            for (std::size_t j = 0; j < 4; ++j) out.third[j][i] = static_cast<float>(third[j]);
        }
    return out;
}

/// The same surface seen from within: -k2 takes the part of k1, t2 that of t1, e2 that of -e1.
inline void turn_inside_out(GBuffer& b) {
    for (std::size_t i = 0; i < b.n_pixels(); ++i) {
        std::swap(b.k1[i], b.k2[i]);
        b.k1[i] = -b.k1[i], b.k2[i] = -b.k2[i];
        const Vec3f n{b.normal[0][i], b.normal[1][i], b.normal[2][i]};
        const Vec3f t2 = cross(n, Vec3f{b.direction[0][i], b.direction[1][i], b.direction[2][i]});
        for (std::size_t axis = 0; axis < 3; ++axis) b.direction[axis][i] = t2[axis];
        // N x t2 = -t1, along which k2 = -(the old k1) changes by +e1.
        const float e1 = b.third[0][i];
        b.third[0][i] = -b.third[3][i], b.third[3][i] = e1;
    }
}

}  // namespace slim::test
