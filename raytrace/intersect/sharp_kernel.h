#pragma once

#include "raytrace/intersect/ray_kernel.h"
#include "raytrace/intersect/root_kernel.h"
#include "slim/model/sharp_sheets.h"

#include <array>
#include <cstddef>

namespace slim {

/// A sharp surfel made ready for one view: a record for each sheet, all with the same ball. One
/// sheet: a smooth surfel.
struct SharpRecord {
    std::array<DrawRecord, kMostSheets> sheet;
    std::size_t n_sheets = 1;
    Join outer = Join::max, inner = Join::max;
    const HeightHessian* hessian = nullptr;  ///< Surfel::hessian, of one sheet
};

template <class V>
inline V join_lanes(Join how, const V& a, const V& b) {
    return how == Join::max ? stdx::max(a, b) : stdx::min(a, b);
}

/// The sheets' functions along some rays.
template <class V>
struct SharpRays {
    std::array<SurfelRay<V>, kMostSheets> ray;
    std::array<PolynomialLanes<V>, kMostSheets> f;
};

template <int Degree, class V>
inline SharpRays<V> sharp_rays(const SharpRecord& s, const PixelRays<V>& rays,
                               const BallRay<V>& ball) {
    SharpRays<V> out;
    for (std::size_t i = 0; i < s.n_sheets; ++i) {
        out.ray[i] = surfel_ray(s.sheet[i], rays, ball);
        out.f[i] = ray_polynomial<Degree>(s.sheet[i], out.ray[i]);
    }
    return out;
}

/// The joined function at a ray parameter.
template <class V>
inline V joined_value(const SharpRecord& s, const SharpRays<V>& rays, const V& t) {
    const V first = lanes_value(rays.f[0], t);
    if (s.n_sheets == 1) return first;
    V rest = lanes_value(rays.f[1], t);
    for (std::size_t k = 2; k < s.n_sheets; ++k)
        rest = join_lanes(s.inner, rest, lanes_value(rays.f[k], t));
    return join_lanes(s.outer, first, rest);
}

/// Whether a root t of sheet i lies on the joined surface:
/// F with f_i set to 0 stays 0 (SharpSheets).
template <class V>
inline typename V::mask_type on_joined_surface(const SharpRecord& s, const SharpRays<V>& rays,
                                               std::size_t i, const V& t) {
    if (s.n_sheets == 1) return typename V::mask_type(true);
    std::array<V, kMostSheets> f;
    for (std::size_t k = 0; k < s.n_sheets; ++k)
        f[k] = k == i ? V(0.0f) : lanes_value(rays.f[k], t);
    V rest = f[1];
    for (std::size_t k = 2; k < s.n_sheets; ++k) rest = join_lanes(s.inner, rest, f[k]);
    return stdx::abs(join_lanes(s.outer, f[0], rest)) <= static_cast<float>(kEdgeTolerance);
}

/// A root of the joined function per lane and the number of the sheet it is on.
template <class V>
struct SharpRoot {
    RootLanes<V> root;
    V sheet;
};

/// The root in [lo, hi] of least cost(t) among those on the joined surface.
template <int Degree, class V, class Cost>
inline SharpRoot<V> best_joined_root(const SharpRecord& s, const SharpRays<V>& rays, const V& lo,
                                     const V& hi, const typename V::mask_type& active,
                                     Cost&& cost) {
    SharpRoot<V> best{{V(0.0f), typename V::mask_type(false)}, V(0.0f)};
    for (std::size_t i = 0; i < s.n_sheets; ++i) {
        const RootCandidates<V> found = all_roots<Degree, V>(rays.f[i], lo, hi, active);
        for (std::size_t k = 0; k < found.n; ++k) {
            const V& t = found.root[k].t;
            const auto better =
                found.root[k].hit && (!best.root.hit || cost(t) < cost(best.root.t));
            if (stdx::none_of(better)) continue;
            const auto taken = better && on_joined_surface(s, rays, i, t);
            best.root.t = select<V>(taken, t, best.root.t);
            best.root.hit = best.root.hit || taken;
            best.sheet = select<V>(taken, V(static_cast<float>(i)), best.sheet);
        }
    }
    return best;
}

/// Gradient at the roots, each of its own sheet.
template <int Degree, class V>
inline GradientLanes<V> sharp_gradient(const SharpRecord& s, const SharpRays<V>& rays,
                                       const SharpRoot<V>& at) {
    GradientLanes<V> out{V(0.0f), V(0.0f), V(0.0f)};
    for (std::size_t i = 0; i < s.n_sheets; ++i) {
        const SurfelRay<V>& r = rays.ray[i];
        const auto g = gradient_at<Degree, V>(s.sheet[i], r.bu + at.root.t * r.du,
                                              r.bv + at.root.t * r.dv);
        const auto own = at.sheet == static_cast<float>(i);
        out.x = select<V>(own, g.x, out.x);
        out.y = select<V>(own, g.y, out.y);
        out.z = select<V>(own, g.z, out.z);
    }
    return out;
}

/// Hessian at the roots, each of its own sheet.
template <int Degree, class V>
inline std::array<V, 6> sharp_hessian(const SharpRecord& s, const SharpRays<V>& rays,
                                      const SharpRoot<V>& at) {
    std::array<V, 6> out;
    out.fill(V(0.0f));
    for (std::size_t i = 0; i < s.n_sheets; ++i) {
        const SurfelRay<V>& r = rays.ray[i];
        const V u = r.bu + at.root.t * r.du, v = r.bv + at.root.t * r.dv;
        const auto h = hessian_from<V>(
            s.sheet[i], s.hessian ? s.hessian->at(u, v)
                                  : second_derivatives<Degree, V>(s.sheet[i], u, v));
        const auto own = at.sheet == static_cast<float>(i);
        for (std::size_t k = 0; k < 6; ++k) out[k] = select<V>(own, h[k], out[k]);
    }
    return out;
}

/// Third derivatives at the roots, each of its own sheet.
template <class V>
inline std::array<V, 10> sharp_third(const SharpRecord& s, const SharpRoot<V>& at) {
    std::array<V, 10> out;
    out.fill(V(0.0f));
    for (std::size_t i = 0; i < s.n_sheets; ++i) {
        const auto third = third_of(s.sheet[i]);
        const auto own = at.sheet == static_cast<float>(i);
        for (std::size_t k = 0; k < 10; ++k) out[k] = select<V>(own, V(third[k]), out[k]);
    }
    return out;
}

}  // namespace slim
