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
