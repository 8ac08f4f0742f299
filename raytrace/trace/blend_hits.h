#pragma once

#include "raytrace/trace/first_hits.h"
#include "slim/blend/blend.h"

#include <array>
#include <cstddef>

namespace slim {

/// Sums of eqs (6) and (7) around q^, one per lane.
struct BlendLanes {
    FloatV weight{0.0f}, offset{0.0f};  ///< offset: of the roots from q^ along the ray, scene units
    FloatV passing{0.0f};  ///< sum G of the surfels that hits in doubt pass over
    FloatV count{0.0f};
    FloatV spread{0.0f};  ///< largest distance of a root from q^
    LanesOfVec gradient{Vec3f{}};
    std::array<FloatV, 6> hessian;  ///< 1 / scene unit
    std::array<FloatV, 10> third;

    void clear_derivatives() {
        hessian.fill(FloatV(0.0f));
        third.fill(FloatV(0.0f));
    }
};

/// Rays about their first hits.
struct RaysAtHits {
    LanesOfVec point, point_low;  ///< q^ and what its floats lack
    LanesOfVec direction;
    LanesOfVec gradient;  ///< that set q^: the gate
    FloatV::mask_type hit;
};

/// Lanes whose gradient agrees with that of q^ (Gate in slim/blend).
[[gnu::always_inline]] inline FloatV::mask_type admits(const RaysAtHits& at, bool closely,
                                                       const LanesOfVec& g) {
    const FloatV agreement = g.dot(at.gradient);
    if (!closely) return agreement > 0.0f;
    return agreement >
           static_cast<float>(kSharpGate) * stdx::sqrt(g.dot(g) * at.gradient.dot(at.gradient));
}

/// q^ relative to a surfel's centre, over rho.
[[gnu::always_inline]] inline LanesOfVec from_center(const TraceRecord& r, const RaysAtHits& at) {
    // The difference of the high parts is exact where it matters: the two are near each other.
    const auto difference = [&](const FloatV& p, const FloatV& low, std::size_t axis)
        __attribute__((always_inline)) {
        return ((p - FloatV(r.center[axis])) + (low - FloatV(r.center_low[axis]))) *
               FloatV(r.inv_radius);
    };
    return {difference(at.point.x, at.point_low.x, 0), difference(at.point.y, at.point_low.y, 1),
            difference(at.point.z, at.point_low.z, 2)};
}

/// Adds a root at `tau` from q^ (units of rho): eqs (6) and (7) with the weight's share.
[[gnu::always_inline]] inline FloatV add_root(const TraceRecord& r, const FloatV::mask_type& taken,
                                              const FloatV& share, const FloatV& sq_distance,
                                              const FloatV& tau, const LanesOfVec& g,
                                              BlendLanes& sums) {
    const FloatV zero(0.0f);
    const FloatV w = select<FloatV>(taken, share * blend_weight(sq_distance), zero);
    const FloatV away = select<FloatV>(taken, tau * FloatV(r.radius), zero);
    sums.weight += w;
    sums.offset += w * away;
    sums.spread = stdx::max(sums.spread, stdx::abs(away));
    sums.count += select<FloatV>(taken, FloatV(1.0f), zero);
    sums.gradient = sums.gradient + g * w;
    return w;
}

/// Stage 2 of one smooth surfel, with the gates of add_supporter (slim/blend).
template <int Degree, Derivatives kWanted>
[[gnu::always_inline]] inline void blend_smooth(const TraceRecord& r, const RaysAtHits& at,
                                                bool closely, BlendLanes& sums) {
    constexpr auto kFarthest = static_cast<float>(kBelongs);
    const LanesOfVec base = from_center(r, at);
    const FloatV sq_base = base.dot(base);
    const auto inside = at.hit && sq_base < 1.0f;
    if (stdx::none_of(inside)) return;
    const KernelRay kernel(base, at.direction);
    const SurfelRay<FloatV> s = surfel_ray<FloatV>(r, kernel.rays, kernel.ball);
    const auto k = ray_polynomial<Degree, FloatV>(r, s);
    const BallLanes<FloatV> ball{sq_base - FloatV(1.0f), 2.0f * base.dot(at.direction),
                                 FloatV(1.0f)};
    const auto root = nearest_in_ball<Degree, FloatV>(k, ball, kFarthest * 1.001f, inside);
    const FloatV u = s.bu + root.t * s.du, v = s.bv + root.t * s.dv;
    const auto g = gradient_at<Degree, FloatV>(r, u, v);
    const LanesOfVec gradient{g.x, g.y, g.z};
    auto taken = root.hit && stdx::abs(root.t) <= kFarthest && admits(at, closely, gradient);
    FloatV share(1.0f);
    if (r.rims.any()) {
        share = RimLanes(r.rims).share(u, v);
        taken = taken && share > 0.0f;
    }
    if (stdx::none_of(taken)) return;
    const FloatV sq_distance = ball.value(root.t) + FloatV(1.0f);
    const FloatV w = add_root(r, taken, share, sq_distance, root.t, gradient, sums);
    if constexpr (kWanted >= Derivatives::second) {
        const auto h = hessian_at<Degree, FloatV>(r, u, v);
        for (std::size_t n = 0; n < 6; ++n) sums.hessian[n] += w * h[n];
    }
    if constexpr (kWanted >= Derivatives::third) {
        const auto c = third_of(r);
        for (std::size_t n = 0; n < 10; ++n) sums.third[n] += w * c[n];
    }
}

/// The same of a sharp surfel.
template <int Degree, Derivatives kWanted>
inline void blend_sharp(const TraceRecord& r, const SharpRecord& sharp, const RaysAtHits& at,
                        BlendLanes& sums) {
    const LanesOfVec base = from_center(r, at);
    const auto inside = at.hit && base.dot(base) < 1.0f;
    if (stdx::none_of(inside)) return;
    const FloatV along = base.dot(at.direction);
    const KernelRay kernel(base - at.direction * along, at.direction);
    const SharpRays<FloatV> f = sharp_rays<Degree>(sharp, kernel.rays, kernel.ball);
    const FloatV half =
        stdx::sqrt(stdx::max(1.0f - (base.dot(base) - along * along), FloatV(0.0f)));
    const auto found = best_joined_root<Degree, FloatV>(
        sharp, f, -half, half, inside, [along](const FloatV& x) { return stdx::abs(x - along); });
    const auto g = sharp_gradient<Degree, FloatV>(sharp, f, found);
    const LanesOfVec gradient{g.x, g.y, g.z};
    const FloatV tau = found.root.t - along;
    const auto taken = found.root.hit && stdx::abs(tau) <= static_cast<float>(kBelongs) &&
                       admits(at, true, gradient);
    if (stdx::none_of(taken)) return;
    const LanesOfVec x = base + at.direction * tau;
    const FloatV w = add_root(r, taken, FloatV(1.0f), x.dot(x), tau, gradient, sums);
    if constexpr (kWanted >= Derivatives::second) {
        const auto h = sharp_hessian<Degree, FloatV>(sharp, f, found);
        for (std::size_t n = 0; n < 6; ++n) sums.hessian[n] += w * h[n];
    }
    if constexpr (kWanted >= Derivatives::third) {
        const auto c = sharp_third<FloatV>(sharp, found);
        for (std::size_t n = 0; n < 10; ++n) sums.third[n] += w * c[n];
    }
}

/// Adds the weight of a smooth surfel where rays pass over it at q^ (passing_weight in slim/blend).
template <int Degree>
[[gnu::always_inline]] inline void pass_smooth(const TraceRecord& r, const RaysAtHits& at,
                                               bool closely, FloatV& passing) {
    constexpr auto kFarthest = static_cast<float>(kBelongs);
    const LanesOfVec base = from_center(r, at);
    const FloatV sq_base = base.dot(base);
    const auto inside = at.hit && sq_base < 1.0f;
    if (stdx::none_of(inside)) return;
    const KernelRay kernel(base, at.direction);
    const SurfelRay<FloatV> s = surfel_ray<FloatV>(r, kernel.rays, kernel.ball);
    const auto k = ray_polynomial<Degree, FloatV>(r, s);
    const auto above = inside && k[0] > 0.0f;
    if (stdx::none_of(above)) return;
    const BallLanes<FloatV> ball{sq_base - FloatV(1.0f), 2.0f * base.dot(at.direction),
                                 FloatV(1.0f)};
    const auto root = nearest_in_ball<Degree, FloatV>(k, ball, kFarthest * 1.001f, above);
    const auto g = gradient_at<Degree, FloatV>(r, s.bu, s.bv);
    const auto passed = above && !(root.hit && stdx::abs(root.t) <= kFarthest) &&
                        admits(at, closely, {g.x, g.y, g.z});
    const FloatV share = r.rims.any() ? RimLanes(r.rims).share(s.bu, s.bv) : FloatV(1.0f);
    passing += select<FloatV>(passed, share * blend_weight(sq_base), FloatV(0.0f));
}

/// The same of a sharp surfel.
template <int Degree>
inline void pass_sharp(const TraceRecord& r, const SharpRecord& sharp, const RaysAtHits& at,
                       FloatV& passing) {
    const LanesOfVec base = from_center(r, at);
    const FloatV sq_base = base.dot(base);
    const auto inside = at.hit && sq_base < 1.0f;
    if (stdx::none_of(inside)) return;
    const FloatV along = base.dot(at.direction);
    const KernelRay kernel(base - at.direction * along, at.direction);
    const SharpRays<FloatV> f = sharp_rays<Degree>(sharp, kernel.rays, kernel.ball);
    const auto above = inside && joined_value<FloatV>(sharp, f, along) > 0.0f;
    if (stdx::none_of(above)) return;
    const FloatV half = stdx::sqrt(stdx::max(1.0f - (sq_base - along * along), FloatV(0.0f)));
    const auto found = best_joined_root<Degree, FloatV>(
        sharp, f, -half, half, above, [along](const FloatV& x) { return stdx::abs(x - along); });
    FloatV::mask_type admitted(false);
    for (std::size_t i = 0; i < sharp.n_sheets; ++i) {
        const auto g = gradient_at<Degree, FloatV>(
            sharp.sheet[i], f.ray[i].bu + along * f.ray[i].du, f.ray[i].bv + along * f.ray[i].dv);
        admitted = admitted || admits(at, true, {g.x, g.y, g.z});
    }
    const auto near = found.root.hit &&
                      stdx::abs(found.root.t - along) <= static_cast<float>(kBelongs);
    passing += select<FloatV>(above && !near && admitted, blend_weight(sq_base), FloatV(0.0f));
}

/// Adds the weight of one surfel where rays pass over it at q^.
[[gnu::flatten]] inline void pass_surfel(const TraceModel& model, const TraceRecord& r,
                                         const RaysAtHits& at, FloatV& passing) {
    if (r.sharp != TraceRecord::kNotSharp) {
        const SharpRecord& sharp = model.sharp[r.sharp];
        if (r.degree == 3) pass_sharp<3>(r, sharp, at, passing);
        else pass_sharp<2>(r, sharp, at, passing);
    } else if (r.degree == 2) {
        pass_smooth<2>(r, at, model.is_sharp, passing);
    } else if (r.degree == 1) {
        pass_smooth<1>(r, at, model.is_sharp, passing);
    } else {
        pass_smooth<3>(r, at, model.is_sharp, passing);
    }
}

/// Stage 2 of one surfel.
template <Derivatives kWanted>
[[gnu::flatten]] inline void blend_surfel(const TraceModel& model, const TraceRecord& r,
                                          const RaysAtHits& at, BlendLanes& sums) {
    if (r.sharp != TraceRecord::kNotSharp) {
        const SharpRecord& sharp = model.sharp[r.sharp];
        if (r.degree == 3)
            blend_sharp<3, kWanted>(r, sharp, at, sums);
        else
            blend_sharp<2, kWanted>(r, sharp, at, sums);
    } else if (r.degree == 2) {
        blend_smooth<2, kWanted>(r, at, model.is_sharp, sums);
    } else if (r.degree == 1) {
        blend_smooth<1, kWanted>(r, at, model.is_sharp, sums);
    } else {
        blend_smooth<3, kWanted>(r, at, model.is_sharp, sums);
    }
}

}  // namespace slim
