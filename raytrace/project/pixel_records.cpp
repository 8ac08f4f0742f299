#include "raytrace/project/pixel_records.h"

#include "raytrace/project/linear_forms.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

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
    r.ball_s = static_cast<float>(2 * form.mu.x);
    r.ball_t = static_cast<float>(2 * form.mu.y);
    r.ball_tau = static_cast<float>(sq_length(form.mu));
}

std::array<float, 3> floats(const Vec3d& v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// A surfel's axes in the camera's, its coordinates times h as functions of (s, t, tau), and h.
struct LocalForm {
    Vec3d e_u, e_v, e_w;
    Linear u, v, w, h;
    const std::array<double, kMaxCoefficients>& a;
};

/// h^Degree (w - P(u, v)): a product with h for each degree that a term lacks.
template <int Degree>
Form<Degree> height_form(const LocalForm& p) {
    const auto& a = p.a;
    if constexpr (Degree <= 1) {
        return p.w - a[0] * p.h;
    } else {
        const Linear plane = p.w - a[0] * p.h - a[1] * p.u - a[2] * p.v;
        const Form<2> quadric = p.h * plane - p.u * (a[3] * p.u + a[4] * p.v) - p.v * (a[5] * p.v);
        if constexpr (Degree == 2) return quadric;
        else return p.h * quadric - p.u * (p.u * (a[6] * p.u + a[7] * p.v)) - p.v * (p.v * (a[8] * p.u + a[9] * p.v));
    }
}

/// h (e_w - e_u P_u - e_v P_v).
void put_gradient(const LocalForm& p, PixelRecord<2>& r) {
    const auto& a = p.a;
    const Linear slope_u = a[1] * p.h + (2 * a[3]) * p.u + a[4] * p.v;
    const Linear slope_v = a[2] * p.h + a[4] * p.u + (2 * a[5]) * p.v;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const Linear g = p.e_w[axis] * p.h - p.e_u[axis] * slope_u - p.e_v[axis] * slope_v;
        for (std::size_t k = 0; k < 4; ++k) r.gradient[axis][k] = static_cast<float>(g.c[k]);
    }
}

/// Second derivatives along the surfel's axes, over -rho, in the camera's.
std::array<float, 6> turned(const LocalForm& p, double uu, double uv, double vv, double radius) {
    const Vec3d along_u = (p.e_u * uu + p.e_v * uv) / -radius, along_v = (p.e_u * uv + p.e_v * vv) / -radius;
    std::array<float, 6> out;
    std::size_t at = 0;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = i; j < 3; ++j)
            out[at++] = static_cast<float>(along_u[i] * p.e_u[j] + along_v[i] * p.e_v[j]);
    return out;
}

template <int Degree>
void put_hessian(const LocalForm& p, double radius, PixelRecord<Degree>& r) {
    const auto& a = p.a;
    r.hessian[0] = turned(p, 2 * a[3], a[4], 2 * a[5], radius);
    if constexpr (Degree == 3) {
        r.hessian[1] = turned(p, 6 * a[6], 2 * a[7], 2 * a[8], radius);
        r.hessian[2] = turned(p, 2 * a[7], 2 * a[8], 6 * a[9], radius);
    }
}

}  // namespace

RayForm ray_form(const PixelView& view, const Vec3d& c, double radius) {
    if (view.orthographic)
        return {{0, 0, 1}, 0, view.center_x + c.x * view.px_per_unit, view.center_y + c.y * view.px_per_unit,
                1 / (view.px_per_unit * radius)};
    const double x = c.x / c.z, y = c.y / c.z;
    return {{x, y, 1}, radius / c.z, view.center_x + x * view.focal_px, view.center_y + y * view.focal_px,
            c.z / (view.focal_px * radius)};
}

template <int Degree>
void fill_pixel_record(const PixelView& view, const Surfel& s, const RayForm& form, PixelRecord<Degree>& r) {
    put_grid(form, r);
    r.radius = static_cast<float>(s.support_radius);
    r.inv_radius = static_cast<float>(1 / s.support_radius);
    const Vec3d e_u = view.rotate_to_camera(s.frame.u_axis), e_v = view.rotate_to_camera(s.frame.v_axis),
                e_w = view.rotate_to_camera(s.frame.normal);
    r.u_axis = floats(e_u), r.v_axis = floats(e_v), r.normal = floats(e_w);
    for (std::size_t k = 0; k < r.a.size(); ++k) r.a[k] = static_cast<float>(s.polynomial.a[k]);
    const auto along = [&](const Vec3d& axis) { return Linear{{0, axis.x, axis.y, dot(axis, form.mu)}}; };
    const LocalForm local{e_u, e_v, e_w, along(e_u), along(e_v), along(e_w), {{1, 0, 0, -form.kappa}}, s.polynomial.a};
    for (std::size_t k = 0; k < 3; ++k) {
        r.u[k] = static_cast<float>(local.u.c[k + 1]);
        r.v[k] = static_cast<float>(local.v.c[k + 1]);
    }
    const Form<Degree> f = height_form<Degree>(local);
    for (std::size_t k = 0; k < r.f.size(); ++k) r.f[k] = static_cast<float>(f.c[k]);
    if constexpr (Degree == 2) put_gradient(local, r);
    put_hessian(local, s.support_radius, r);
}

template void fill_pixel_record<1>(const PixelView&, const Surfel&, const RayForm&, PixelRecord<1>&);
template void fill_pixel_record<2>(const PixelView&, const Surfel&, const RayForm&, PixelRecord<2>&);
template void fill_pixel_record<3>(const PixelView&, const Surfel&, const RayForm&, PixelRecord<3>&);

}  // namespace slim
