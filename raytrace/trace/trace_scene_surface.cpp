// What is seen along rays: the blend about their first hits.

#include "raytrace/trace/trace_scene.h"
#include "raytrace/trace/traverse.h"

#include <bit>

namespace slim {
namespace {

std::uint32_t record_at(const FirstHits& hits, int lane) {
    return std::bit_cast<std::uint32_t>(
        static_cast<float>(hits.record[static_cast<std::size_t>(lane)]));
}

/// q^ to a few units of the second float.
void points_on(const RayPacket& rays, const FloatV& t, RaysAtHits& at) {
    const TwoFloatVecs p =
        place_along({rays.origin, rays.origin_low}, {rays.direction, rays.direction_low}, t);
    at.point = p.high, at.point_low = p.low;
}

/// Stage 2 within one model, for the lanes whose q^ is its own.
template <Derivatives kWanted>
void blend_in(const TraceModel& model, const RaysAtHits& at, BlendLanes& sums,
              TraceCounts& counts) {
    for_leaves_around(model.bvh, model.balls, at.point, at.hit, [&](const BvhNode& leaf) {
        for (std::uint32_t k = 0; k < leaf.n_items; ++k)
            blend_surfel<kWanted>(model, model.records[leaf.first + k], at, sums);
        counts.distance_tests += leaf.n_items * std::uint64_t{kLanes};
    });
}

/// What says that lanes in doubt (is_in_doubt in slim/blend) show no surface.
void pass_in(const TraceModel& model, RaysAtHits at, BlendLanes& sums, TraceCounts& counts) {
    at.hit = at.hit && is_in_doubt<FloatV>(sums.weight);
    if (stdx::none_of(at.hit)) return;
    for_leaves_around(model.bvh, model.balls, at.point, at.hit, [&](const BvhNode& leaf) {
        for (std::uint32_t k = 0; k < leaf.n_items; ++k)
            pass_surfel(model, model.records[leaf.first + k], at, sums.passing);
        counts.distance_tests += leaf.n_items * std::uint64_t{kLanes};
    });
}

void blend_in(const TraceModel& model, Derivatives wanted, const RaysAtHits& at, BlendLanes& sums,
              TraceCounts& counts) {
    switch (wanted) {
        case Derivatives::first:
            return blend_in<Derivatives::first>(model, at, sums, counts);
        case Derivatives::second:
            return blend_in<Derivatives::second>(model, at, sums, counts);
        case Derivatives::third:
            return blend_in<Derivatives::third>(model, at, sums, counts);
    }
}

/// Average of the roots, and the point and the normal there; q^ and its own without weight.
void average(const RaysAtHits& at, const FloatV& t_first, SurfaceHits& out) {
    const FloatV zero(0.0f);
    const auto blended = at.hit && out.sums.weight > 0.0f;
    const FloatV offset = select<FloatV>(blended, out.sums.offset / out.sums.weight, zero);
    out.t = select<FloatV>(at.hit, t_first + offset, FloatV(kFar));
    const auto moved = [&](const FloatV& p, const FloatV& low, const FloatV& d, FloatV& high,
                           FloatV& rest) {
        const FloatV step = low + offset * d;
        high = p + step;
        rest = (p - high) + step;
    };
    moved(at.point.x, at.point_low.x, at.direction.x, out.point.x, out.point_low.x);
    moved(at.point.y, at.point_low.y, at.direction.y, out.point.y, out.point_low.y);
    moved(at.point.z, at.point_low.z, at.direction.z, out.point.z, out.point_low.z);
    out.normal = select_vec(blended, out.sums.gradient, at.gradient).unit();
}

/// Lengths of some lanes from one unit to another.
void scale_lengths(const FloatV::mask_type& lanes, Derivatives wanted, const FloatV& unit,
                   BlendLanes& sums) {
    const auto scale = [&](FloatV& x, const FloatV& by) { x = select<FloatV>(lanes, x * by, x); };
    scale(sums.offset, unit), scale(sums.spread, unit);
    if (wanted == Derivatives::first) return;
    const FloatV inverse = 1.0f / unit;
    for (FloatV& h : sums.hessian) scale(h, inverse);
    for (FloatV& c : sums.third) scale(c, inverse * inverse);
}

/// Both stages of lanes whose winner has a frame of its own: found there, told in the scene's.
void surface_in_own_frame(const TraceModel& model, const RayPacket& scene_rays,
                          const FirstHits& hits, const RaysAtHits& scene_at, Derivatives wanted,
                          bool find_passing, SurfaceHits& out, TraceCounts& counts) {
    const PlacedRays placed(model.place, scene_rays);
    RaysAtHits at = scene_at;
    const FloatV t = select<FloatV>(at.hit, hits.own_t, FloatV(0.0f)), unit(model.place.unit);
    points_on(placed.rays, t, at);
    blend_in(model, wanted, at, out.sums, counts);
    if (find_passing) pass_in(model, at, out.sums, counts);
    SurfaceHits own;
    own.sums.weight = out.sums.weight, own.sums.offset = out.sums.offset,
    own.sums.gradient = out.sums.gradient;
    average(at, t, own);
    scale_lengths(at.hit, wanted, unit, out.sums);
    const TwoFloatVecs p = model.place.to_scene({own.point, own.point_low});
    out.t = select<FloatV>(at.hit, (placed.start.high + own.t) * unit, out.t);
    out.point = select_vec(at.hit, p.high, out.point);
    out.point_low = select_vec(at.hit, p.low, out.point_low);
    out.normal = select_vec(at.hit, own.normal, out.normal);
}

}  // namespace

SurfaceHits TraceScene::surface(const RayPacket& rays, Derivatives wanted, TraceCounts& counts,
                                bool clean_outlines) const {
    SurfaceHits out = surface_at_first(rays, wanted, counts, clean_outlines);
    const int most = clean_outlines ? kMostOutvoted : 0;
    for (int round = 0; round < most; ++round) {
        const auto outvoted = out.hit() && is_in_doubt<FloatV>(out.sums.weight) &&
                              is_outvoted<FloatV>(out.sums.weight, out.sums.passing);
        if (stdx::none_of(outvoted)) break;
        RayPacket behind = rays;
        behind.looks_behind = true;
        behind.far = select<FloatV>(outvoted, rays.far, FloatV(-1.0f));
        behind.last_t = select<FloatV>(outvoted, out.first_t, FloatV(0.0f));
        behind.last_t_low = out.first_t_low;
        out.take(outvoted, surface_at_first(behind, wanted, counts, true), wanted);
    }
    return out;
}

SurfaceHits TraceScene::surface_at_first(const RayPacket& rays, Derivatives wanted,
                                         TraceCounts& counts, bool find_passing) const {
    SurfaceHits out;
    const FirstHits hits = first_hits(rays, out.model, counts);
    RaysAtHits at;
    at.hit = rays.active() && hits.t < kFar;
    if (stdx::none_of(at.hit)) return out;
    out.first_t = hits.t, out.first_t_low = hits.t_low;
    at.direction = rays.direction, at.gradient = hits.gradient;
    const FloatV t = select<FloatV>(at.hit, hits.t, FloatV(0.0f));
    points_on(rays, t, at);
    if (wanted > Derivatives::first) out.sums.clear_derivatives();
    const auto of_model = [&](std::uint32_t m) {
        RaysAtHits own = at;
        if (models_.size() > 1)
            own.hit =
                own.hit && FloatV([&](auto k) { return out.model[k] == m ? 1.0f : 0.0f; }) > 0.0f;
        return own;
    };
    for (std::uint32_t m = 0; m < models_.size(); ++m) {
        if (!models_[m].place.is_scene) continue;
        const RaysAtHits own = of_model(m);
        if (stdx::none_of(own.hit)) continue;
        blend_in(models_[m], wanted, own, out.sums, counts);
        if (find_passing) pass_in(models_[m], own, out.sums, counts);
    }
    average(at, hits.t, out);
    for (std::uint32_t m = 0; m < models_.size(); ++m) {
        if (models_[m].place.is_scene) continue;
        const RaysAtHits own = of_model(m);
        if (stdx::any_of(own.hit))
            surface_in_own_frame(models_[m], rays, hits, own, wanted, find_passing, out, counts);
    }
    for (std::uint64_t bits = lane_bits(at.hit); bits != 0; bits &= bits - 1) {
        const int lane = std::countr_zero(bits);
        const auto k = static_cast<std::size_t>(lane);
        const TraceModel& model = models_[out.model[k]];
        out.record[k] = record_at(hits, lane);
        out.clearance[k] = model.records[out.record[k]].clearance * model.place.unit;
    }
    return out;
}

}  // namespace slim
