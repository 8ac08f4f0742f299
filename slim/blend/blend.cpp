#include "slim/blend/blend.h"

#include "slim/model/weight_kernel.h"

#include <cmath>

namespace slim {
namespace {

/// H += weight * Hess f at local (u, v): sum over a, b of -P_ab / rho e_a e_b^T (NUMERICS 5.1).
void add_hessian(const Surfel& s, double u, double v, double weight, SymmetricMatrix& h) {
    const double scale = -weight / s.support_radius;
    const double uu = scale * s.polynomial.d_uu(u, v);
    const double uv = scale * s.polynomial.d_uv(u, v);
    const double vv = scale * s.polynomial.d_vv(u, v);
    const Vec3d &eu = s.frame.u_axis, &ev = s.frame.v_axis;
    const Vec3d a = eu * uu + ev * uv, b = eu * uv + ev * vv;  // H = a eu^T + b ev^T
    h[0] += a.x * eu.x + b.x * ev.x;
    h[1] += a.x * eu.y + b.x * ev.y;
    h[2] += a.x * eu.z + b.x * ev.z;
    h[3] += a.y * eu.y + b.y * ev.y;
    h[4] += a.y * eu.z + b.y * ev.z;
    h[5] += a.z * eu.z + b.z * ev.z;
}

}  // namespace

bool add_supporter(const Ray& ray, double t_guess, const Vec3d& gate, const Surfel& surfel,
                   bool want_hessian, BlendSums& sums) {
    const LocalRay local = local_ray(ray, surfel);
    const double guess = (t_guess - local.t_base) / surfel.support_radius;
    if (!(local.sq_distance + guess * guess < 1)) return false;
    const double s = local.half_chord();
    const auto root = ray_roots(ray_polynomial(local, surfel.polynomial), -s, s).nearest(guess);
    if (!root || !(std::abs(*root - guess) <= kBelongs)) return false;
    const Vec3d q = local.base + local.direction * *root;
    const Vec3d gradient = world_gradient(surfel, q.x, q.y);
    if (!(dot(gradient, gate) > 0)) return false;
    const double weight = weight_kernel(sq_length(q));
    sums.weight += weight;
    sums.t += weight * (local.t_base + surfel.support_radius * *root);
    sums.gradient += gradient * weight;
    if (want_hessian) add_hessian(surfel, q.x, q.y, weight, sums.hessian);
    ++sums.count;
    return true;
}

std::optional<double> first_hit(const Ray& ray, const Surfel& surfel, double t_min, double trim,
                                Vec3d& gradient) {
    const LocalRay local = local_ray(ray, surfel);
    if (!local.meets_ball(trim)) return std::nullopt;
    const double s = local.half_chord(trim);
    const double lo = std::max(-s, (t_min - local.t_base) / surfel.support_radius);
    const auto root = ray_roots(ray_polynomial(local, surfel.polynomial), lo, s).first();
    if (!root) return std::nullopt;
    const Vec3d q = local.base + local.direction * *root;
    gradient = world_gradient(surfel, q.x, q.y);
    return local.t_base + surfel.support_radius * *root;
}

std::optional<Projection> project_along(const Vec3d& p, const Vec3d& n,
                                        std::span<const Surfel* const> supporters,
                                        bool want_curvature) {
    BlendSums sums;
    for (const Surfel* s : supporters) add_supporter({p, n}, 0.0, n, *s, want_curvature, sums);
    if (!(sums.weight > 0)) return std::nullopt;
    Projection out;
    out.t = sums.t / sums.weight;
    out.point = p + n * out.t;
    out.gradient = sums.gradient / sums.weight;
    out.normal = normalized(sums.gradient);
    out.weight = sums.weight;
    out.n_supporters = sums.count;
    if (want_curvature) out.curvature = curvature_from(sums.gradient, sums.hessian);
    return out;
}

std::optional<Vec3d> normal_at(const Vec3d& p, std::span<const Surfel* const> supporters) {
    Vec3d sum;
    for (const Surfel* s : supporters) {
        const Vec3d local = s->frame.local_from_world((p - s->center) / s->support_radius);
        const double sq = sq_length(local);
        if (sq < 1) sum += world_gradient(*s, local.x, local.y) * weight_kernel(sq);
    }
    if (!(sq_length(sum) > 0)) return std::nullopt;
    return normalized(sum);
}

}  // namespace slim
