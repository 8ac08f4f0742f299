#include "raytrace/project/pixel_records.h"

#include "raytrace/project/linear_forms.h"
#include "slim/base/lane_turns.h"

#include <algorithm>
#include <cstring>

namespace slim {
namespace {

using Floats = FloatsOfDouble;
template <int Degree>
using RecordLanes = PixelRecord<Degree, Floats>;

/// The pixels at some coordinates, bounded so that floats hold them exactly.
DoubleV nearest_pixel(const DoubleV& at) {
    constexpr double kLimit = 1 << 23;
    return stdx::min(stdx::max(stdx::floor(at), DoubleV(-kLimit)), DoubleV(kLimit));
}

template <class Record>
void put_grid(const RayForm& form, const PixelGrid& grid, Record& r) {
    r.pixel_x = grid.pixel_x, r.pixel_y = grid.pixel_y;
    r.base_x = grid.base_x, r.base_y = grid.base_y, r.step = grid.step;
    r.kappa = floats_of(form.kappa);
    r.ball_s = floats_of(2.0 * form.mu.x);
    r.ball_t = floats_of(2.0 * form.mu.y);
    r.ball_tau = floats_of(sq_length(form.mu));
}

std::array<Floats, 3> floats(const Vec3D& v) {
    return {floats_of(v.x), floats_of(v.y), floats_of(v.z)};
}

/// The surfels' coordinates times h as functions of (s, t, tau), and h.
struct LocalForm {
    const SurfelLanes& surfel;
    Linear u, v, w, h;

    LocalForm(const SurfelLanes& s, const RayForm& form) : surfel(s) {
        const auto along = [&](const Vec3D& axis) {
            return Linear{{DoubleV(0.0), axis.x, axis.y, dot(axis, form.mu)}};
        };
        u = along(s.e_u), v = along(s.e_v), w = along(s.e_w);
        h = {{DoubleV(1.0), DoubleV(0.0), DoubleV(0.0), -form.kappa}};
    }
};

/// h^Degree (w - P(u, v)): a product with h for each degree that a term lacks.
template <int Degree>
Form<Degree> height_form(const LocalForm& p) {
    const auto& a = p.surfel.a;
    if constexpr (Degree <= 1) {
        return p.w - a[0] * p.h;
    } else {
        const Linear plane = p.w - a[0] * p.h - a[1] * p.u - a[2] * p.v;
        const Form<2> quadric = p.h * plane - p.u * (a[3] * p.u + a[4] * p.v) - p.v * (a[5] * p.v);
        if constexpr (Degree == 2) return quadric;
        else
            return p.h * quadric - p.u * (p.u * (a[6] * p.u + a[7] * p.v)) -
                   p.v * (p.v * (a[8] * p.u + a[9] * p.v));
    }
}

/// h (e_w - e_u P_u - e_v P_v).
void put_gradient(const LocalForm& p, RecordLanes<2>& r) {
    const SurfelLanes& s = p.surfel;
    const Linear slope_u = s.a[1] * p.h + (2.0 * s.a[3]) * p.u + s.a[4] * p.v;
    const Linear slope_v = s.a[2] * p.h + s.a[4] * p.u + (2.0 * s.a[5]) * p.v;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const Linear g = s.e_w[axis] * p.h - s.e_u[axis] * slope_u - s.e_v[axis] * slope_v;
        for (std::size_t k = 0; k < 4; ++k) r.gradient[axis][k] = floats_of(g.c[k]);
    }
}

/// Lane k to *out[k], unless that is null.
template <int Degree>
void scatter(const RecordLanes<Degree>& lanes,
             const std::array<PixelRecord<Degree>*, kSurfelLanes>& out) {
    // Records of floats and of lanes have the same members in the same order,
    // and room for some more.
    constexpr std::size_t kNumbers = sizeof(PixelRecord<Degree>) / sizeof(float),
                          kMembers = sizeof(RecordLanes<Degree>) / sizeof(Floats);
    static_assert(kNumbers % 4 == 0 && sizeof(Floats) == kSurfelLanes * sizeof(float));
    PixelRecord<Degree> nowhere;
    std::array<float*, kSurfelLanes> to;
    for (std::size_t lane = 0; lane < kSurfelLanes; ++lane)
        to[lane] = reinterpret_cast<float*>(out[lane] ? out[lane] : &nowhere);
    const auto member = [&](std::size_t k) {
        Floats x(0.0f);
        if (k < kMembers)
            std::memcpy(&x, reinterpret_cast<const char*>(&lanes) + k * sizeof(Floats), sizeof x);
        return x;
    };
#pragma GCC unroll 64
    for (std::size_t k = 0; k < kNumbers; k += 4)
        store_fours(member(k), member(k + 1), member(k + 2), member(k + 3),
                    [&](std::size_t lane) { return to[lane] + k; });
}

}  // namespace

RayForm ray_form(const PixelView& view, const SurfelLanes& s) {
    const Vec3D& c = s.center;
    if (view.orthographic)
        return {{DoubleV(0.0), DoubleV(0.0), DoubleV(1.0)},
                DoubleV(0.0),
                view.center_x + c.x * view.px_per_unit,
                view.center_y + c.y * view.px_per_unit,
                1.0 / (view.px_per_unit * s.radius)};
    const DoubleV x = c.x / c.z, y = c.y / c.z;
    return {{x, y, DoubleV(1.0)},
            s.radius / c.z,
            view.center_x + x * view.focal_px,
            view.center_y + y * view.focal_px,
            c.z / (view.focal_px * s.radius)};
}

PixelGrid::PixelGrid(const RayForm& form) {
    const DoubleV px = nearest_pixel(form.origin_x), py = nearest_pixel(form.origin_y);
    pixel_x = floats_of(px), pixel_y = floats_of(py);
    base_x = floats_of((px + 0.5 - form.origin_x) * form.step);
    base_y = floats_of((py + 0.5 - form.origin_y) * form.step);
    step = floats_of(form.step);
}

template <int Degree>
[[gnu::flatten]] void fill_pixel_records(
    const SurfelLanes& s, const RayForm& form, const PixelGrid& grid,
    const std::array<PixelRecord<Degree>*, kSurfelLanes>& out) {
    RecordLanes<Degree> r;
    put_grid(form, grid, r);
    r.radius = floats_of(s.radius);
    r.inv_radius = floats_of(1.0 / s.radius);
    if constexpr (Degree != 2)
        r.u_axis = floats(s.e_u), r.v_axis = floats(s.e_v), r.normal = floats(s.e_w);
    for (std::size_t k = 0; k < r.a.size(); ++k) r.a[k] = floats_of(s.a[k]);
    const LocalForm local(s, form);
    for (std::size_t k = 0; k < 3; ++k) {
        r.u[k] = floats_of(local.u.c[k + 1]);
        r.v[k] = floats_of(local.v.c[k + 1]);
    }
    const Form<Degree> f = height_form<Degree>(local);
    for (std::size_t k = 0; k < r.f.size(); ++k) r.f[k] = floats_of(f.c[k]);
    if constexpr (Degree == 2) put_gradient(local, r);
    scatter(r, out);
}

template void fill_pixel_records<1>(const SurfelLanes&, const RayForm&, const PixelGrid&,
                                    const std::array<PixelRecord<1>*, kSurfelLanes>&);
template void fill_pixel_records<2>(const SurfelLanes&, const RayForm&, const PixelGrid&,
                                    const std::array<PixelRecord<2>*, kSurfelLanes>&);
template void fill_pixel_records<3>(const SurfelLanes&, const RayForm&, const PixelGrid&,
                                    const std::array<PixelRecord<3>*, kSurfelLanes>&);

}  // namespace slim
