#pragma once

#include "slim/base/vec.h"
#include "slim/blend/roots.h"
#include "slim/model/surfel.h"

#include <cmath>

namespace slim {

/// A straight line p + t d in the frame of the job; |d| = 1.
struct Ray {
    Vec3d origin;
    Vec3d direction;
};

/// A ray in a surfel's own coordinates (relative to the centre, over rho): base + t direction, |t|
/// in units of rho, `base` the point of the ray closest to the centre.
struct LocalRay {
    Vec3d base;
    Vec3d direction;
    double sq_distance;  ///< |base|^2; the ray meets the ball if < 1
    double t_base;       ///< parameter of `base` on the world ray: t_world = t_base + rho t

    bool meets_ball(double relative_radius = 1) const {
        return sq_distance < relative_radius * relative_radius;
    }
    /// Half the chord inside the ball of relative_radius rho; the ray must meet it.
    double half_chord(double relative_radius = 1) const {
        return std::sqrt(relative_radius * relative_radius - sq_distance);
    }
};

/// Set-up of a ray against a sheet of a surfel (NUMERICS 4.1),
/// in doubles. Error about 1e-16 |o - c| / rho.
inline LocalRay local_ray(const Ray& ray, const Surfel& s, std::size_t sheet = 0) {
    const Vec3d to_center = s.center - ray.origin;
    const double t_base = dot(to_center, ray.direction);
    const Vec3d base = (ray.direction * t_base - to_center) / s.support_radius;
    const Frame<double>& frame = s.sheet_frame(sheet);
    LocalRay local{frame.local_from_world(base), frame.local_from_world(ray.direction), 0, t_base};
    local.sq_distance = sq_length(local.base);
    return local;
}

/// f = w - P(u, v) along base + t direction (NUMERICS 4.1).
inline RayPolynomial<double> ray_polynomial(const LocalRay& ray, const Polynomial<double>& p) {
    const Vec3d &b = ray.base, &d = ray.direction;
    const auto& a = p.a;
    const double second = d.x * d.x * p.d_uu(b.x, b.y) + 2 * d.x * d.y * p.d_uv(b.x, b.y) +
                          d.y * d.y * p.d_vv(b.x, b.y);
    const double third = d.x * d.x * (a[6] * d.x + a[7] * d.y) +
                         d.y * d.y * (a[8] * d.x + a[9] * d.y);
    return {b.z - p.value(b.x, b.y),
            d.z - (p.d_u(b.x, b.y) * d.x + p.d_v(b.x, b.y) * d.y), -0.5 * second, -third};
}

/// Gradient of f at local (u, v), in world axes, times rho: of length >= 1, pointing outwards.
inline Vec3d world_gradient(const Surfel& s, double u, double v, std::size_t sheet = 0) {
    const Polynomial<double>& p = s.sheet_polynomial(sheet);
    return s.sheet_frame(sheet).world_from_local({-p.d_u(u, v), -p.d_v(u, v), 1.0});
}

}  // namespace slim
