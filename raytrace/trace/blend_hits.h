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

/// A surfel's ball about q^; lengths over rho.
struct BallAtHits {
    LanesOfVec base;     ///< q^ from the centre
    FloatV sq_distance;  ///< of q^ from there
    FloatV::mask_type inside;

    [[gnu::always_inline]] BallAtHits(const TraceRecord& r, const RaysAtHits& at)
        : base(from_center(r, at)), sq_distance(base.dot(base)) {
        inside = at.hit && sq_distance < 1.0f;
    }
};

/// A smooth surfel along the rays; parameters count from q^.
template <int Degree>
struct SmoothAtHits {
    SurfelRay<FloatV> s;
    PolynomialLanes<FloatV> f;
    BallLanes<FloatV> ball;

    [[gnu::always_inline]] SmoothAtHits(const TraceRecord& r, const RaysAtHits& at,
                                        const BallAtHits& in) {
        const KernelRay kernel(in.base, at.direction);
        s = surfel_ray<FloatV>(r, kernel.rays, kernel.ball);
        f = ray_polynomial<Degree, FloatV>(r, s);
        ball = {in.sq_distance - FloatV(1.0f), 2.0f * in.base.dot(at.direction), FloatV(1.0f)};
    }
    /// Of some lanes the root nearest q^, as far as kBelongs and a little.
    [[gnu::always_inline]] RootLanes<FloatV> root(const FloatV::mask_type& lanes) const {
        constexpr auto kFarthest = static_cast<float>(kBelongs) * 1.001f;
        return nearest_in_ball<Degree, FloatV>(f, ball, kFarthest, lanes);
    }
};

/// A sharp surfel along the rays; parameters count from the point nearest its centre.
template <int Degree>
struct SharpAtHits {
    const SharpRecord& sharp;
    FloatV sq_distance;  ///< of q^ from the centre
    FloatV along;        ///< to q^
    SharpRays<FloatV> f;

    SharpAtHits(const SharpRecord& record, const RaysAtHits& at, const BallAtHits& in)
        : sharp(record), sq_distance(in.sq_distance), along(in.base.dot(at.direction)) {
        const KernelRay kernel(in.base - at.direction * along, at.direction);
        f = sharp_rays<Degree>(sharp, kernel.rays, kernel.ball);
    }
    /// Of some lanes the root of the joined function nearest q^.
    SharpRoot<FloatV> root(const FloatV::mask_type& lanes) const {
        const FloatV half =
            stdx::sqrt(stdx::max(1.0f - (sq_distance - along * along), FloatV(0.0f)));
        return best_joined_root<Degree, FloatV>(
            sharp, f, -half, half, lanes,
            [q = along](const FloatV& x) { return stdx::abs(x - q); });
    }
};

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
[[gnu::always_inline]] inline void blend_smooth(const TraceRecord& r, const HeightHessian* hessian,
                                                const RaysAtHits& at, bool closely,
                                                BlendLanes& sums) {
    const BallAtHits in(r, at);
    if (stdx::none_of(in.inside)) return;
    const SmoothAtHits<Degree> surfel(r, at, in);
    const auto root = surfel.root(in.inside);
    const FloatV u = surfel.s.bu + root.t * surfel.s.du, v = surfel.s.bv + root.t * surfel.s.dv;
    const auto g = gradient_at<Degree, FloatV>(r, u, v);
    const LanesOfVec gradient{g.x, g.y, g.z};
    auto taken = root.hit && stdx::abs(root.t) <= static_cast<float>(kBelongs) &&
                 admits(at, closely, gradient);
    FloatV share(1.0f);
    if (r.rims.any()) {
        share = RimLanes(r.rims).share(u, v);
        taken = taken && share > 0.0f;
    }
    if (stdx::none_of(taken)) return;
    const FloatV sq_distance = surfel.ball.value(root.t) + FloatV(1.0f);
    const FloatV w = add_root(r, taken, share, sq_distance, root.t, gradient, sums);
    if constexpr (kWanted >= Derivatives::second) {
        const auto h = hessian_from<FloatV>(
            r, hessian ? hessian->at(u, v) : second_derivatives<Degree, FloatV>(r, u, v));
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
    const BallAtHits in(r, at);
    if (stdx::none_of(in.inside)) return;
    const SharpAtHits<Degree> surfel(sharp, at, in);
    const auto found = surfel.root(in.inside);
    const auto g = sharp_gradient<Degree, FloatV>(sharp, surfel.f, found);
    const LanesOfVec gradient{g.x, g.y, g.z};
    const FloatV tau = found.root.t - surfel.along;
    const auto taken = found.root.hit && stdx::abs(tau) <= static_cast<float>(kBelongs) &&
                       admits(at, true, gradient);
    if (stdx::none_of(taken)) return;
    const LanesOfVec x = in.base + at.direction * tau;
    const FloatV w = add_root(r, taken, FloatV(1.0f), x.dot(x), tau, gradient, sums);
    if constexpr (kWanted >= Derivatives::second) {
        const auto h = sharp_hessian<Degree, FloatV>(sharp, surfel.f, found);
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
    const BallAtHits in(r, at);
    if (stdx::none_of(in.inside)) return;
    const SmoothAtHits<Degree> surfel(r, at, in);
    const auto above = in.inside && surfel.f[0] > 0.0f;
    if (stdx::none_of(above)) return;
    const auto root = surfel.root(above);
    const FloatV &u = surfel.s.bu, &v = surfel.s.bv;
    const auto g = gradient_at<Degree, FloatV>(r, u, v);
    const auto near = root.hit && stdx::abs(root.t) <= static_cast<float>(kBelongs);
    const auto passed = above && !near && admits(at, closely, {g.x, g.y, g.z});
    const FloatV share = r.rims.any() ? RimLanes(r.rims).share(u, v) : FloatV(1.0f);
    passing += select<FloatV>(passed, share * blend_weight(in.sq_distance), FloatV(0.0f));
}

/// The same of a sharp surfel.
template <int Degree>
inline void pass_sharp(const TraceRecord& r, const SharpRecord& sharp, const RaysAtHits& at,
                       FloatV& passing) {
    const BallAtHits in(r, at);
    if (stdx::none_of(in.inside)) return;
    const SharpAtHits<Degree> surfel(sharp, at, in);
    const FloatV& q = surfel.along;
    const auto above = in.inside && joined_value<FloatV>(sharp, surfel.f, q) > 0.0f;
    if (stdx::none_of(above)) return;
    const auto found = surfel.root(above);
    FloatV::mask_type admitted(false);
    for (std::size_t i = 0; i < sharp.n_sheets; ++i) {
        const SurfelRay<FloatV>& ray = surfel.f.ray[i];
        const auto g = gradient_at<Degree, FloatV>(sharp.sheet[i], ray.bu + q * ray.du,
                                                   ray.bv + q * ray.dv);
        admitted = admitted || admits(at, true, {g.x, g.y, g.z});
    }
    const auto near =
        found.root.hit && stdx::abs(found.root.t - q) <= static_cast<float>(kBelongs);
    passing += select<FloatV>(above && !near && admitted, blend_weight(in.sq_distance),
                              FloatV(0.0f));
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
    const HeightHessian* hessian = kWanted >= Derivatives::second ? model.hessian_of(r) : nullptr;
    if (r.sharp != TraceRecord::kNotSharp) {
        const SharpRecord& sharp = model.sharp[r.sharp];
        if (r.degree == 3)
            blend_sharp<3, kWanted>(r, sharp, at, sums);
        else
            blend_sharp<2, kWanted>(r, sharp, at, sums);
    } else if (r.degree == 2) {
        blend_smooth<2, kWanted>(r, hessian, at, model.is_sharp, sums);
    } else if (r.degree == 1) {
        blend_smooth<1, kWanted>(r, hessian, at, model.is_sharp, sums);
    } else {
        blend_smooth<3, kWanted>(r, hessian, at, model.is_sharp, sums);
    }
}

}  // namespace slim
