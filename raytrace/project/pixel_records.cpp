#include "raytrace/project/pixel_records.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

/// A polynomial in tau, degree 3 at most.
using Tau = std::array<double, 4>;

Tau operator+(const Tau& a, const Tau& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]}; }
Tau operator*(double f, const Tau& a) { return {f * a[0], f * a[1], f * a[2], f * a[3]}; }
/// Of degree 1 times of degree 2.
Tau times(const Tau& a, const Tau& b) {
    return {a[0] * b[0], a[0] * b[1] + a[1] * b[0], a[0] * b[2] + a[1] * b[1], a[1] * b[2]};
}

/// q = tau mu + (1 + kappa tau) (s, t, 0) in camera axes.
struct RayForm {
    Vec3d mu;
    double kappa;
    double origin_x, origin_y;  ///< pixel coordinates where s = t = 0
    double step;                ///< of s and t a pixel
};

RayForm ray_form(const PixelView& view, const Vec3d& c, double radius) {
    if (view.orthographic)
        return {{0, 0, 1}, 0, view.center_x + c.x * view.px_per_unit, view.center_y + c.y * view.px_per_unit,
                1 / (view.px_per_unit * radius)};
    const double x = c.x / c.z, y = c.y / c.z;
    return {{x, y, 1}, radius / c.z, view.center_x + x * view.focal_px, view.center_y + y * view.focal_px,
            c.z / (view.focal_px * radius)};
}

/// The pixel at some coordinate, bounded so that floats hold it exactly.
double nearest_pixel(double at) {
    constexpr double kLimit = 1 << 23;
    return std::clamp(std::floor(at), -kLimit, kLimit);
}

template <class Record>
void put_grid(const RayForm& form, Record& r) {
    const double px = nearest_pixel(form.origin_x), py = nearest_pixel(form.origin_y);
    r.pixel_x = static_cast<float>(px), r.pixel_y = static_cast<float>(py);
    r.base_x = static_cast<float>((px + 0.5 - form.origin_x) * form.step);
    r.base_y = static_cast<float>((py + 0.5 - form.origin_y) * form.step);
    r.step = static_cast<float>(form.step);
    r.kappa = static_cast<float>(form.kappa);
}

/// |q|^2 = tau^2 |mu|^2 + 2 tau (1 + kappa tau) mu . (s, t) + (1 + kappa tau)^2 (s^2 + t^2).
template <int Degree>
void put_ball(const RayForm& f, PixelRecord<Degree>& r) {
    const std::array<double, 3> square{0, 0, sq_length(f.mu)}, kappa{1, 2 * f.kappa, f.kappa * f.kappa};
    const std::array<double, 3> in_s{0, 2 * f.mu.x, 2 * f.kappa * f.mu.x};
    const std::array<double, 3> in_t{0, 2 * f.mu.y, 2 * f.kappa * f.mu.y};
    for (std::size_t k = 0; k < 3; ++k) {
        r.ball_s[k] = static_cast<float>(in_s[k]);
        r.ball_ss[k] = static_cast<float>(kappa[k]);
        r.row[0][r.kBall + k] = static_cast<float>(square[k]);
        r.row[1][r.kBall + k] = static_cast<float>(in_t[k]);
        r.row[2][r.kBall + k] = static_cast<float>(kappa[k]);
    }
}

std::array<float, 3> floats(const Vec3d& v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// The term s^i t^j of f, by powers of tau.
template <int Degree>
void put_term(int i, int j, const Tau& value, PixelRecord<Degree>& r) {
    for (int k = 0; k <= Degree; ++k) {
        const auto v = static_cast<float>(value[static_cast<std::size_t>(k)]);
        if (i == Degree) r.top[static_cast<std::size_t>(k)] = v;
        else r.row[static_cast<std::size_t>(j)][static_cast<std::size_t>(k * Degree + i)] = v;
    }
}

/// A surfel's axes in the camera's, and P at mu(tau).
struct LocalForm {
    Vec3d e_u, e_v, e_w;
    Tau u, v, w;      ///< of mu
    Tau kappa;
    const std::array<double, kMaxCoefficients>& a;
};

/// f = w - P(u, v) at u = mu_u + kappa e_u . (s, t, 0), ...: Taylor's terms in (s, t) at mu(tau), exact.
template <int Degree>
void put_polynomial(const LocalForm& p, PixelRecord<Degree>& r) {
    const auto& a = p.a;
    const Tau uu = times(p.u, p.u), uv = times(p.u, p.v), vv = times(p.v, p.v);
    Tau f = p.w + -a[1] * p.u + -a[2] * p.v;
    f[0] -= a[0];
    Tau p_u{a[1]}, p_v{a[2]}, p_uu{a[3]}, p_uv{a[4]}, p_vv{a[5]};  // of the second ones a half
    if constexpr (Degree >= 2) {
        f = f + -a[3] * uu + -a[4] * uv + -a[5] * vv;
        p_u = p_u + 2 * a[3] * p.u + a[4] * p.v;
        p_v = p_v + a[4] * p.u + 2 * a[5] * p.v;
    }
    if constexpr (Degree >= 3) {
        f = f + -a[6] * times(p.u, uu) + -a[7] * times(p.v, uu) + -a[8] * times(p.u, vv) + -a[9] * times(p.v, vv);
        p_u = p_u + 3 * a[6] * uu + 2 * a[7] * uv + a[8] * vv;
        p_v = p_v + a[7] * uu + 2 * a[8] * uv + 3 * a[9] * vv;
        p_uu = p_uu + 3 * a[6] * p.u + a[7] * p.v;
        p_uv = p_uv + 2 * a[7] * p.u + 2 * a[8] * p.v;
        p_vv = p_vv + a[8] * p.u + 3 * a[9] * p.v;
    }
    const Vec3d &g = p.e_u, &h = p.e_v;
    const Tau none{};
    put_term(0, 0, f, r);
    put_term(1, 0, times(p.kappa, Tau{p.e_w.x} + -g.x * p_u + -h.x * p_v), r);
    put_term(0, 1, times(p.kappa, Tau{p.e_w.y} + -g.y * p_u + -h.y * p_v), r);
    if constexpr (Degree >= 2) {
        const Tau square = times(p.kappa, p.kappa);
        // kappa^2 is of degree 2, the second derivatives of degree 1.
        const auto second = [&](double u2, double u1v1, double v2) {
            return times(none + -u2 * p_uu + -u1v1 * p_uv + -v2 * p_vv, square);
        };
        put_term(2, 0, second(g.x * g.x, g.x * h.x, h.x * h.x), r);
        put_term(1, 1, second(2 * g.x * g.y, g.x * h.y + g.y * h.x, 2 * h.x * h.y), r);
        put_term(0, 2, second(g.y * g.y, g.y * h.y, h.y * h.y), r);
        if constexpr (Degree >= 3) {
            const Tau cube = times(p.kappa, square);
            const auto third = [&](double u3, double u2v, double uv2, double v3) {
                return -(a[6] * u3 + a[7] * u2v + a[8] * uv2 + a[9] * v3) * cube;
            };
            put_term(3, 0, third(g.x * g.x * g.x, g.x * g.x * h.x, g.x * h.x * h.x, h.x * h.x * h.x), r);
            put_term(2, 1, third(3 * g.x * g.x * g.y, g.x * (g.x * h.y + 2 * g.y * h.x),
                                 h.x * (h.x * g.y + 2 * h.y * g.x), 3 * h.x * h.x * h.y), r);
            put_term(1, 2, third(3 * g.y * g.y * g.x, g.y * (g.y * h.x + 2 * g.x * h.y),
                                 h.y * (h.y * g.x + 2 * h.x * g.y), 3 * h.y * h.y * h.x), r);
            put_term(0, 3, third(g.y * g.y * g.y, g.y * g.y * h.y, g.y * h.y * h.y, h.y * h.y * h.y), r);
        }
    }
}

/// n - e_u P_u - e_v P_v at u = u_tau tau + (1 + kappa tau) e_u . (s, t, 0), ...
void put_gradient(const LocalForm& p, PixelRecord<2>& r) {
    const auto& a = p.a;
    const auto turned = [&](double p_u, double p_v) { return p.e_u * -p_u + p.e_v * -p_v; };
    const auto change = [&](double u, double v) {
        return turned(2 * a[3] * u + a[4] * v, a[4] * u + 2 * a[5] * v);
    };
    const Vec3d constant = p.e_w + turned(a[1], a[2]), in_tau = change(p.u[1], p.v[1]);
    const Vec3d in_s = change(p.e_u.x, p.e_v.x), in_t = change(p.e_u.y, p.e_v.y);
    r.gradient_s = floats(in_s);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        r.row[0][r.kGradient + axis] = static_cast<float>(constant[axis]);
        r.row[1][r.kGradient + axis] = static_cast<float>(in_t[axis]);
        r.row[0][r.kGradient + 3 + axis] = static_cast<float>(in_tau[axis]);
        r.row[1][r.kGradient + 3 + axis] = static_cast<float>(p.kappa[1] * in_t[axis]);
    }
}

}  // namespace

template <int Degree>
void fill_pixel_record(const PixelView& view, const Surfel& s, PixelRecord<Degree>& r) {
    r = {};
    const Vec3d c = view.camera_from_local(s.center);
    const RayForm form = ray_form(view, c, s.support_radius);
    put_grid(form, r);
    put_ball(form, r);
    r.radius = static_cast<float>(s.support_radius);
    r.inv_radius = static_cast<float>(1 / s.support_radius);
    const Vec3d e_u = view.rotate_to_camera(s.frame.u_axis), e_v = view.rotate_to_camera(s.frame.v_axis),
                e_w = view.rotate_to_camera(s.frame.normal);
    r.u_axis = floats(e_u), r.v_axis = floats(e_v), r.normal = floats(e_w);
    for (std::size_t k = 0; k < r.a.size(); ++k) r.a[k] = static_cast<float>(s.polynomial.a[k]);
    const auto along = [&](const Vec3d& axis) { return Tau{0, dot(axis, form.mu)}; };
    const LocalForm local{e_u, e_v, e_w, along(e_u), along(e_v), along(e_w), {1, form.kappa},
                          s.polynomial.a};
    r.u_tau = static_cast<float>(local.u[1]), r.v_tau = static_cast<float>(local.v[1]);
    put_polynomial(local, r);
    if constexpr (Degree == 2) put_gradient(local, r);
}

template void fill_pixel_record<1>(const PixelView&, const Surfel&, PixelRecord<1>&);
template void fill_pixel_record<2>(const PixelView&, const Surfel&, PixelRecord<2>&);
template void fill_pixel_record<3>(const PixelView&, const Surfel&, PixelRecord<3>&);

}  // namespace slim
