#pragma once

#include "raytrace/intersect/blend_lanes.h"
#include "raytrace/intersect/pixel_kernel.h"
#include "raytrace/intersect/sharp_kernel.h"
#include "raytrace/trace/ray_packet.h"
#include "raytrace/trace/trace_model.h"
#include "slim/blend/blend.h"

#include <bit>
#include <cstdint>

namespace slim {

/// First hits of a packet so far (stage 1): q^ and what stage 2 needs to know of it.
struct FirstHits {
    FloatV t{kFar};       ///< also the far end of the search; negative: no ray
    FloatV record{0.0f};  ///< bits of the record's number
    LanesOfVec gradient;  ///< of the winner, times rho
    FloatV t_low{0.0f};   ///< what t lacks, of winners in a frame of their own; else 0
    FloatV own_t{
        0.0f};  ///< of winners in a frame of their own: there, from where their PlacedRays begin

    /// Lanes where a root t of record number `id` comes first; of equal ones the lower number does,
    /// so that a lane's hit does not depend on the order of the search.
    [[gnu::always_inline]] FloatV::mask_type nearer(const FloatV& at, const FloatV& id) const {
        return at < t || (at == t && id < record);
    }
};

/// A surfel's ball along some rays: the point nearest its centre (over rho) and where on the ray it
/// is.
struct RayAtBall {
    LanesOfVec p;
    FloatV t;  ///< units of the model's frame
    FloatV sq_distance;

    [[gnu::always_inline]] RayAtBall(const TraceRecord& r, const RayPacket& rays) {
        const LanesOfVec from{FloatV(r.center[0]) - rays.origin.x,
                              FloatV(r.center[1]) - rays.origin.y,
                              FloatV(r.center[2]) - rays.origin.z};
        t = from.dot(rays.direction);
        p = (rays.direction * t - from) * FloatV(r.inv_radius);
        sq_distance = p.dot(p);
    }
};

/// The first parameter at which a surfel's root is looked for: the ray's start, or a little behind
/// what was outvoted.
[[gnu::always_inline]] inline FloatV least_root(const TraceRecord& r, const RayPacket& rays,
                                                const FloatV& start) {
    if (!rays.looks_behind) return start;
    // Of small surfels far off no less than floats tell.
    constexpr float kRounding = 4e-7f;
    const FloatV last = rays.last_t * FloatV(r.inv_radius);
    return start + last + stdx::max(FloatV(static_cast<float>(kNextHit)), kRounding * last);
}

/// The same in the words of the kernels that forward projection uses.
struct KernelRay {
    PixelRays<FloatV> rays;
    BallRay<FloatV> ball;

    [[gnu::always_inline]] KernelRay(const LanesOfVec& base, const LanesOfVec& d) {
        rays.dx = d.x, rays.dy = d.y, rays.dz = d.z;
        ball.px = base.x, ball.py = base.y, ball.pz = base.z;
    }
};

/// Lanes whose ray leaves the very surface it would hit: its origin lies in the surfel's ball and
/// belongs to it, and the hit is of the same sheet there: its gradient agrees with the normal
/// closely, or it agrees at all and the hit is a way out to the side that the ray left on. The
/// surfels about a point differ by more than eps where their cores end, and each but the outermost
/// would else lie in the shadow of another.
[[gnu::always_inline]] inline FloatV::mask_type leaves_own(const RayPacket& rays,
                                                           const FloatV& sq_origin,
                                                           const FloatV& f_origin,
                                                           const LanesOfVec& g) {
    const FloatV agreement = g.dot(rays.normal);
    const FloatV out = g.dot(rays.direction) * rays.normal.dot(rays.direction);
    const auto close = agreement > static_cast<float>(kSharpGate) * stdx::sqrt(g.dot(g));
    const auto same_sheet = close || (agreement > 0.0f && out > 0.0f);
    return sq_origin < 1.0f && stdx::abs(f_origin) <= static_cast<float>(kBelongs) && same_sheet;
}

/// Takes first hits along: keeps the nearest.
struct KeepNearest {
    FirstHits& hits;

    [[gnu::always_inline]] const FloatV& far() const { return hits.t; }
    template <class Gradient>
    [[gnu::always_inline]] void operator()(const FloatV::mask_type& hit, const FloatV& t,
                                           const FloatV& id, Gradient&& gradient) const {
        const auto nearer = hit && hits.nearer(t, id);
        if (stdx::none_of(nearer)) return;
        hits.t = select<FloatV>(nearer, t, hits.t);
        hits.record = select<FloatV>(nearer, id, hits.record);
        const GradientLanes<FloatV> g = gradient();
        hits.gradient = select_vec(nearer, {g.x, g.y, g.z}, hits.gradient);
    }
};

/// Any hit ends a ray: its far end becomes negative.
struct EndAtAny {
    FloatV& end;

    [[gnu::always_inline]] const FloatV& far() const { return end; }
    template <class Gradient>
    [[gnu::always_inline]] void operator()(const FloatV::mask_type& hit, const FloatV& t,
                                           const FloatV&, Gradient&&) const {
        end = select<FloatV>(hit && t <= end, FloatV(-1.0f), end);
    }
};

/// Stage 1 of one smooth surfel: its first root in the shrunken ball, this side of its rim. Returns
/// whether roots were asked for.
template <int Degree, class Keep>
[[gnu::always_inline]] inline bool smooth_hits(const TraceRecord& r, std::uint32_t number,
                                               const RayPacket& rays, const Keep& keep) {
    constexpr auto kSqTrim = static_cast<float>(kHitTrim * kHitTrim);
    const RayAtBall at(r, rays);
    const auto met = at.sq_distance < kSqTrim && keep.far() >= 0.0f;
    if (stdx::none_of(met)) return false;
    const KernelRay kernel(at.p, rays.direction);
    const SurfelRay<FloatV> s = surfel_ray<FloatV>(r, kernel.rays, kernel.ball);
    const auto k = ray_polynomial<Degree, FloatV>(r, s);
    const BallLanes<FloatV> ball{at.sq_distance - FloatV(kSqTrim), FloatV(0.0f), FloatV(1.0f)};
    const FloatV start = -at.t * FloatV(r.inv_radius);
    const auto root = first_in_ball<Degree, FloatV>(k, ball, static_cast<float>(kHitTrim),
                                                    least_root(r, rays, start));
    const FloatV t = at.t + root.t * FloatV(r.radius);
    auto hit = root.hit && met && t <= keep.far();
    if (stdx::none_of(hit)) return true;
    const FloatV u = s.bu + root.t * s.du, v = s.bv + root.t * s.dv;
    if (r.rims.any()) hit = hit && RimLanes(r.rims).share(u, v) > 0.0f;
    if (rays.leaves_surface) {
        const auto g = gradient_at<Degree, FloatV>(r, u, v);
        const FloatV sq_origin = at.sq_distance + start * start, f = lanes_value<FloatV>(k, start);
        hit = hit && !leaves_own(rays, sq_origin, f, {g.x, g.y, g.z});
    }
    keep(
        hit, t, FloatV(std::bit_cast<float>(number)), [&]() __attribute__((always_inline)) {
            return gradient_at<Degree, FloatV>(r, u, v);
        });
    return true;
}

/// The same of a sharp surfel: the first root of the joined function.
template <int Degree, class Keep>
inline bool sharp_hits(const TraceRecord& r, const SharpRecord& sharp, std::uint32_t number,
                       const RayPacket& rays, const Keep& keep) {
    constexpr auto kSqTrim = static_cast<float>(kSharpHitTrim * kSharpHitTrim);
    const RayAtBall at(r, rays);
    const auto met = at.sq_distance < kSqTrim && keep.far() >= 0.0f;
    if (stdx::none_of(met)) return false;
    const KernelRay kernel(at.p, rays.direction);
    const SharpRays<FloatV> f = sharp_rays<Degree>(sharp, kernel.rays, kernel.ball);
    const FloatV half = stdx::sqrt(stdx::max(kSqTrim - at.sq_distance, FloatV(0.0f)));
    const FloatV start = -at.t * FloatV(r.inv_radius);
    const auto found = best_joined_root<Degree, FloatV>(
        sharp, f, stdx::max(-half, least_root(r, rays, start)), half, met,
        [](const FloatV& x) { return x; });
    const FloatV t = at.t + found.root.t * FloatV(r.radius);
    auto hit = found.root.hit && t <= keep.far();
    if (stdx::none_of(hit)) return true;
    if (rays.leaves_surface) {
        const auto g = sharp_gradient<Degree, FloatV>(sharp, f, found);
        const FloatV sq_origin = at.sq_distance + start * start;
        hit = hit && !leaves_own(rays, sq_origin, FloatV(0.0f), {g.x, g.y, g.z});
    }
    keep(hit, t, FloatV(std::bit_cast<float>(number)),
         [&] { return sharp_gradient<Degree, FloatV>(sharp, f, found); });
    return true;
}

/// Stage 1 of the surfel with this number in its model.
template <class Keep>
[[gnu::flatten]] inline bool surfel_hits(const TraceModel& model, std::uint32_t number,
                                         const RayPacket& rays, const Keep& keep) {
    const TraceRecord& r = model.records[number];
    if (r.sharp != TraceRecord::kNotSharp) {
        const SharpRecord& sharp = model.sharp[r.sharp];
        return r.degree == 3 ? sharp_hits<3>(r, sharp, number, rays, keep)
                             : sharp_hits<2>(r, sharp, number, rays, keep);
    }
    if (r.degree == 2) return smooth_hits<2>(r, number, rays, keep);
    return r.degree == 1 ? smooth_hits<1>(r, number, rays, keep)
                         : smooth_hits<3>(r, number, rays, keep);
}

}  // namespace slim
