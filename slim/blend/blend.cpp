#include "slim/blend/blend.h"

#include "slim/blend/sharp_root.h"
#include "slim/model/weight_kernel.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

/// P_uu, P_uv, P_vv at a root.
std::array<double, 3> second_derivatives(const Surfel& s, const SheetRoot& root) {
    const double u = root.local.x, v = root.local.y;
    if (s.hessian) return s.hessian->at(u, v);
    const Polynomial<double>& p = s.sheet_polynomial(root.sheet);
    return {p.d_uu(u, v), p.d_uv(u, v), p.d_vv(u, v)};
}

/// H += weight * Hess f at a root: sum over a, b of -P_ab / rho e_a e_b^T (NUMERICS 5.1).
void add_hessian(const Surfel& s, const SheetRoot& root, double weight, SymmetricMatrix& h) {
    const double scale = -weight / s.support_radius;
    const auto p = second_derivatives(s, root);
    const double uu = scale * p[0], uv = scale * p[1], vv = scale * p[2];
    const Frame<double>& frame = s.sheet_frame(root.sheet);
    const Vec3d &eu = frame.u_axis, &ev = frame.v_axis;
    const Vec3d a = eu * uu + ev * uv, b = eu * uv + ev * vv;  // H = a eu^T + b ev^T
    h[0] += a.x * eu.x + b.x * ev.x;
    h[1] += a.x * eu.y + b.x * ev.y;
    h[2] += a.x * eu.z + b.x * ev.z;
    h[3] += a.y * eu.y + b.y * ev.y;
    h[4] += a.y * eu.z + b.y * ev.z;
    h[5] += a.z * eu.z + b.z * ev.z;
}

/// C += weight * D3 f: sum over a, b, c of -P_abc / rho^2 e_a e_b e_c (NUMERICS 5.1).
void add_third(const Surfel& s, const SheetRoot& root, double weight, SymmetricTensor& c) {
    const double scale = -weight / (s.support_radius * s.support_radius);
    const auto p = s.sheet_polynomial(root.sheet).third();
    const Frame<double>& frame = s.sheet_frame(root.sheet);
    const Vec3d &e = frame.u_axis, &f = frame.v_axis;
    const auto entry = [&](std::size_t i, std::size_t j, std::size_t k) {
        return scale * (p[0] * e[i] * e[j] * e[k] +
                        p[1] * (e[i] * e[j] * f[k] + e[i] * f[j] * e[k] + f[i] * e[j] * e[k]) +
                        p[2] * (e[i] * f[j] * f[k] + f[i] * e[j] * f[k] + f[i] * f[j] * e[k]) +
                        p[3] * f[i] * f[j] * f[k]);
    };
    std::size_t at = 0;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = i; j < 3; ++j)
            for (std::size_t k = j; k < 3; ++k) c[at++] += entry(i, j, k);
}

/// Root of a smooth surfel nearest the guess (local, units of rho).
std::optional<SheetRoot> nearest_smooth_root(const LocalRay& local, const Surfel& s, double guess) {
    const double half = local.half_chord();
    const auto root = ray_roots(ray_polynomial(local, s.polynomial), -half, half).nearest(guess);
    if (!root) return std::nullopt;
    return SheetRoot{*root, local.t_base, 0, local.base + local.direction * *root};
}

/// First root of a smooth surfel at local parameters >= t_lo.
std::optional<SheetRoot> first_smooth_root(const LocalRay& local, const Surfel& s, double t_lo,
                                           double trim) {
    const double half = local.half_chord(trim);
    const double lo = std::max(-half, t_lo);
    const auto root = ray_roots(ray_polynomial(local, s.polynomial), lo, half).first();
    if (!root) return std::nullopt;
    return SheetRoot{*root, local.t_base, 0, local.base + local.direction * *root};
}

/// Root of a surfel nearest a parameter of the ray, inside its ball.
std::optional<SheetRoot> nearest_root(const Ray& ray, double t_guess, const Surfel& s) {
    const LocalRay local = local_ray(ray, s);
    const double guess = (t_guess - local.t_base) / s.support_radius;
    if (!(local.sq_distance + guess * guess < 1)) return std::nullopt;
    if (!s.sharp) return nearest_smooth_root(local, s, guess);
    return best_joined_root(ray, s, 1, -INFINITY, [&](double t) { return std::abs(t - guess); });
}

/// Whether a root is near enough to the guess to be of the same sheet.
bool belongs(const SheetRoot& root, double t_guess, const Surfel& s) {
    return std::abs(root.t - (t_guess - root.t_base) / s.support_radius) <= kBelongs;
}

/// Weight below which a supporter, near its ball's or its rim's end, does not say which face is
/// seen (slim/fit/notes/0013).
constexpr double kLeastSay = 0.002;

/// What is seen from p along n: the gradient of the supporter whose root is nearest p, of those
/// that have a say if there are any. n itself where no supporter is sharp:
/// there every one on n's side counts.
Gate gate_at(const Vec3d& p, const Vec3d& n, std::span<const Surfel* const> supporters) {
    Gate gate(n), fringe(n);
    const auto is_sharp = [](const Surfel* s) { return s->sharp != nullptr; };
    if (std::none_of(supporters.begin(), supporters.end(), is_sharp)) return gate;
    double nearest = INFINITY, nearest_fringe = INFINITY;
    for (const Surfel* s : supporters) {
        const auto root = nearest_root({p, n}, 0, *s);
        if (!root) continue;
        const Vec3d g = world_gradient(*s, root->local.x, root->local.y, root->sheet);
        const double t = std::abs(root->t_base + s->support_radius * root->t);
        if (!(dot(g, n) > 0)) continue;
        const bool has_say = rim_share(s->rims, root->local.x, root->local.y) *
                                 weight_kernel(sq_length(root->local)) > kLeastSay;
        double& least = has_say ? nearest : nearest_fringe;
        if (!(t < least)) continue;
        least = t;
        (has_say ? gate : fringe) = Gate(g, true);
    }
    return nearest < INFINITY ? gate : fringe;
}

/// A point that lies beyond the rims of all its supporters still has them:
/// its own surface was left out.
void add_beyond_rims(const Ray& ray, const Gate& gate, std::span<const Surfel* const> supporters,
                     Derivatives wanted, BlendSums& sums) {
    for (const Surfel* s : supporters) {
        if (!s->rims.any()) continue;
        Surfel whole = *s;
        whole.rims = {};
        add_supporter(ray, 0.0, gate, whole, wanted, sums);
    }
}

}  // namespace

bool add_supporter(const Ray& ray, double t_guess, const Gate& gate, const Surfel& surfel,
                   Derivatives wanted, BlendSums& sums) {
    const auto root = nearest_root(ray, t_guess, surfel);
    if (!root || !belongs(*root, t_guess, surfel)) return false;
    const Vec3d gradient = world_gradient(surfel, root->local.x, root->local.y, root->sheet);
    if (!gate.admits(gradient)) return false;
    const double share = rim_share(surfel.rims, root->local.x, root->local.y);
    if (!(share > 0)) return false;
    const double weight = share * weight_kernel(sq_length(root->local));
    sums.weight += weight;
    sums.t += weight * (root->t_base + surfel.support_radius * root->t);
    sums.gradient += gradient * weight;
    if (wanted >= Derivatives::second) add_hessian(surfel, *root, weight, sums.hessian);
    if (wanted >= Derivatives::third) add_third(surfel, *root, weight, sums.third);
    ++sums.count;
    return true;
}

double passing_weight(const Ray& ray, double t_guess, const Gate& gate, const Surfel& surfel) {
    const Vec3d x =
        (ray.origin + ray.direction * t_guess - surfel.center) / surfel.support_radius;
    const double sq = sq_length(x);
    if (!(sq < 1) || !(surfel.value(x) > 0)) return 0;
    const auto root = nearest_root(ray, t_guess, surfel);
    if (root && belongs(*root, t_guess, surfel)) return 0;
    bool admitted = false;
    for (std::size_t i = 0; i < surfel.n_sheets(); ++i)
        admitted = admitted || gate.admits(surfel.sheet_gradient(i, x));
    if (!admitted) return 0;
    const Vec3d local = surfel.frame.local_from_world(x);
    return rim_share(surfel.rims, local.x, local.y) * weight_kernel(sq);
}

std::optional<double> first_hit(const Ray& ray, const Surfel& surfel, double t_min, double trim,
                                Vec3d& gradient) {
    const LocalRay local = local_ray(ray, surfel);
    if (!local.meets_ball(trim)) return std::nullopt;
    const double t_lo = (t_min - local.t_base) / surfel.support_radius;
    const auto root = surfel.sharp ? best_joined_root(ray, surfel, trim, t_lo,
                                                      [](double t) { return t; })
                                   : first_smooth_root(local, surfel, t_lo, trim);
    if (!root || !(rim_share(surfel.rims, root->local.x, root->local.y) > 0))
        return std::nullopt;
    gradient = world_gradient(surfel, root->local.x, root->local.y, root->sheet);
    return local.t_base + surfel.support_radius * root->t;
}

std::optional<Projection> project_along(const Vec3d& p, const Vec3d& n,
                                        std::span<const Surfel* const> supporters,
                                        bool want_curvature) {
    BlendSums sums;
    const Gate gate = gate_at(p, n, supporters);
    const Derivatives wanted = want_curvature ? Derivatives::second : Derivatives::first;
    for (const Surfel* s : supporters) add_supporter({p, n}, 0.0, gate, *s, wanted, sums);
    if (!(sums.weight > 0)) add_beyond_rims({p, n}, gate, supporters, wanted, sums);
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

Vec3d weighted_gradient(const Surfel& s, const Vec3d& p) {
    const Vec3d x = (p - s.center) / s.support_radius;
    const double sq = sq_length(x);
    return sq < 1 ? s.sheet_gradient(s.active_sheet(x), x) * weight_kernel(sq) : Vec3d{};
}

std::optional<Vec3d> normal_at(const Vec3d& p, std::span<const Surfel* const> supporters) {
    Vec3d sum;
    for (const Surfel* s : supporters) sum += weighted_gradient(*s, p);
    if (!(sq_length(sum) > 0)) return std::nullopt;
    return normalized(sum);
}

}  // namespace slim
