#include "raytrace/trace/trace_scene.h"

#include "raytrace/trace/traverse.h"

#include <algorithm>
#include <bit>

namespace slim {
namespace {

Bbox bounds_of(const ScenePart& part) {
    Bbox box;
    for (std::size_t i = 0; i < part.tree->n_nodes(); ++i) {
        if (!part.tree->node(i).is_leaf()) continue;
        const double rho = part.tree->support_radius(i);
        const Vec3d c = part.tree->center(i) + part.offset, reach{rho, rho, rho};
        box.extend(c - reach), box.extend(c + reach);
    }
    return box;
}

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

/// Nearer hits on one model, in the frame of its records.
[[gnu::always_inline]] inline void find_hits(const TraceModel& model, const RayPacket& rays,
                                             FirstHits& hits, TraceCounts& counts) {
    counts.nodes_visited += for_leaves_along(model.bvh, rays, hits.t, [&](const BvhNode& leaf) {
        for (std::uint32_t k = 0; k < leaf.n_items; ++k)
            if (surfel_hits(model, leaf.first + k, rays, KeepNearest{hits}))
                counts.root_tests += kLanes;
    });
}

/// The same of a model with a frame of its own, for rays and hits of the scene's; lanes with nearer
/// ones. A float of the scene does not tell which of two small models comes first: two do.
[[gnu::noinline]] FloatV::mask_type find_hits_in_own_frame(const TraceModel& model,
                                                           const RayPacket& scene_rays,
                                                           FirstHits& hits, TraceCounts& counts) {
    RayPacket up_to = scene_rays;
    up_to.far = hits.t;
    const PlacedRays placed(model.place, up_to, hits.t_low);
    if (stdx::none_of(placed.rays.active())) return FloatV::mask_type(false);
    FirstHits own;
    own.t = placed.rays.far, own.gradient = hits.gradient;
    find_hits(model, placed.rays, own, counts);
    const TwoFloats way = sum_of(placed.start, {own.t, FloatV(0.0f)});
    const FloatV t = way.high * FloatV(model.place.unit),
                 t_low = way.low * FloatV(model.place.unit);
    const auto won = own.t < placed.rays.far && (t < hits.t || (t == hits.t && t_low < hits.t_low));
    hits.t = select<FloatV>(won, t, hits.t);
    hits.t_low = select<FloatV>(won, t_low, hits.t_low);
    hits.own_t = select<FloatV>(won, own.t, hits.own_t);
    hits.record = select<FloatV>(won, own.record, hits.record);
    hits.gradient = select_vec(won, own.gradient, hits.gradient);
    return won;
}

/// Nearer hits on a model in the scene's frame; lanes that have some.
[[gnu::always_inline]] inline FloatV::mask_type find_hits_in_scene(const TraceModel& model,
                                                                   const RayPacket& rays,
                                                                   FirstHits& hits,
                                                                   TraceCounts& counts) {
    const FloatV before = hits.t;
    find_hits(model, rays, hits, counts);
    const auto won = hits.t < before;
    hits.t_low = select<FloatV>(won, FloatV(0.0f), hits.t_low);
    return won;
}

/// Lanes that meet the model this side of `far` get a negative one.
[[gnu::always_inline]] inline void end_at_any(const TraceModel& model, const RayPacket& rays,
                                              FloatV& far, TraceCounts& counts) {
    counts.nodes_visited += for_leaves_along(model.bvh, rays, far, [&](const BvhNode& leaf) {
        for (std::uint32_t k = 0; k < leaf.n_items; ++k)
            if (surfel_hits(model, leaf.first + k, rays, EndAtAny{far}))
                counts.root_tests += kLanes;
    });
}

[[gnu::noinline]] void end_at_any_in_own_frame(const TraceModel& model, const RayPacket& scene_rays,
                                               FloatV& far, TraceCounts& counts) {
    RayPacket up_to = scene_rays;
    up_to.far = far;
    const PlacedRays placed(model.place, up_to);
    if (stdx::none_of(placed.rays.active())) return;
    FloatV own_far = placed.rays.far;
    end_at_any(model, placed.rays, own_far, counts);
    far = select<FloatV>(placed.rays.active() && own_far < 0.0f, FloatV(-1.0f), far);
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

TraceScene::TraceScene(std::span<const ScenePart> parts, bool loose)
    : parts_(parts.begin(), parts.end()) {
    std::vector<Bbox> boxes;
    for (const ScenePart& part : parts_) {
        boxes.push_back(bounds_of(part));
        bounds_.extend(boxes.back());
    }
    frame_.middle = bounds_.center();
    frame_.unit = std::max(0.5 * bounds_.diagonal(), 1e-300);
    for (std::size_t m = 0; m < parts_.size(); ++m)
        models_.push_back(trace_model(*parts_[m].tree, frame_, ModelPlace::of(boxes[m], frame_),
                                      parts_[m].offset, loose));
}

bool TraceScene::is_wide() const {
    return std::any_of(models_.begin(), models_.end(),
                       [](const TraceModel& model) { return !model.place.is_scene; });
}

std::size_t TraceScene::n_surfels() const {
    std::size_t n = 0;
    for (const TraceModel& model : models_) n += model.records.size();
    return n;
}

FirstHits TraceScene::first_hits(const RayPacket& rays, std::array<std::uint32_t, kLanes>& winner,
                                 TraceCounts& counts) const {
    FirstHits hits;
    hits.t = rays.far;
    hits.gradient = LanesOfVec(Vec3f{});
    for (std::uint32_t m = 0; m < models_.size(); ++m) {
        const TraceModel& model = models_[m];
        // A root as far as an earlier model's does not come before it, whatever its number: none is
        // below 0.
        const FloatV earlier = hits.record;
        hits.record = FloatV(0.0f);
        const auto won = model.place.is_scene ? find_hits_in_scene(model, rays, hits, counts)
                                              : find_hits_in_own_frame(model, rays, hits, counts);
        hits.record = select<FloatV>(won, hits.record, earlier);
        for (std::uint64_t bits = lane_bits(won); bits != 0; bits &= bits - 1)
            winner[static_cast<std::size_t>(std::countr_zero(bits))] = m;
    }
    // What has not come nearer than the far end is no hit.
    hits.t = select<FloatV>(hits.t < rays.far, hits.t, FloatV(kFar));
    counts.rays += static_cast<std::uint64_t>(stdx::popcount(rays.active()));
    return hits;
}

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

FloatV::mask_type TraceScene::unblocked(const RayPacket& rays, TraceCounts& counts) const {
    FloatV far = rays.far;
    for (const TraceModel& model : models_)
        if (model.place.is_scene)
            end_at_any(model, rays, far, counts);
        else
            end_at_any_in_own_frame(model, rays, far, counts);
    counts.rays += static_cast<std::uint64_t>(stdx::popcount(rays.active()));
    return rays.active() && far >= 0.0f;
}

}  // namespace slim
