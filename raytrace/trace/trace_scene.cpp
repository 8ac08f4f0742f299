#include "raytrace/trace/trace_scene.h"

#include "raytrace/trace/traverse.h"

#include <algorithm>
#include <bit>
#include <tuple>

namespace slim {
namespace {

Bbox bounds_of(std::span<const ScenePart> parts) {
    Bbox box;
    for (const ScenePart& part : parts)
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

/// o + t d per lane and axis in two floats each: q^ to a few units of the second.
void point_on(const FloatV& o, const FloatV& o_low, const FloatV& d, const FloatV& d_low,
              const FloatV& t, FloatV& high, FloatV& low) {
    const FloatV product = t * d, product_low = lanes_fma<FloatV>(t, d, -product) + t * d_low;
    high = o + product;
    const FloatV back = high - o;
    low = ((o - (high - back)) + (product - back)) + (product_low + o_low);
}

void points_on(const RayPacket& rays, const FloatV& t, RaysAtHits& at) {
    const auto& [o, d, o_low, d_low] =
        std::tie(rays.origin, rays.direction, rays.origin_low, rays.direction_low);
    point_on(o.x, o_low.x, d.x, d_low.x, t, at.point.x, at.point_low.x);
    point_on(o.y, o_low.y, d.y, d_low.y, t, at.point.y, at.point_low.y);
    point_on(o.z, o_low.z, d.z, d_low.z, t, at.point.z, at.point_low.z);
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

}  // namespace

TraceCounts& TraceCounts::operator+=(const TraceCounts& b) {
    rays += b.rays, nodes_visited += b.nodes_visited;
    root_tests += b.root_tests, distance_tests += b.distance_tests;
    return *this;
}

TraceScene::TraceScene(std::span<const ScenePart> parts, bool loose)
    : parts_(parts.begin(), parts.end()), bounds_(bounds_of(parts)) {
    frame_.middle = bounds_.center();
    frame_.unit = std::max(0.5 * bounds_.diagonal(), 1e-300);
    for (const ScenePart& part : parts_)
        models_.push_back(trace_model(*part.tree, frame_, part.offset, loose));
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
        // A root as far as an earlier model's does not come before it, whatever its number: none is below 0.
        const FloatV before = hits.t, earlier = hits.record;
        hits.record = FloatV(0.0f);
        counts.nodes_visited += for_leaves_along(model.bvh, rays, hits.t, [&](const BvhNode& leaf) {
            for (std::uint32_t k = 0; k < leaf.n_items; ++k)
                if (surfel_hits(model, leaf.first + k, rays, KeepNearest{hits}))
                    counts.root_tests += kLanes;
        });
        const auto won = hits.t < before;
        hits.record = select<FloatV>(won, hits.record, earlier);
        for (std::uint64_t bits = lane_bits(won); bits != 0; bits &= bits - 1)
            winner[static_cast<std::size_t>(std::countr_zero(bits))] = m;
    }
    // What has not come nearer than the far end is no hit.
    hits.t = select<FloatV>(hits.t < rays.far, hits.t, FloatV(kFar));
    counts.rays += static_cast<std::uint64_t>(stdx::popcount(rays.active()));
    return hits;
}

SurfaceHits TraceScene::surface(const RayPacket& rays, Derivatives wanted,
                                TraceCounts& counts) const {
    SurfaceHits out;
    const FirstHits hits = first_hits(rays, out.model, counts);
    RaysAtHits at;
    at.hit = rays.active() && hits.t < kFar;
    if (stdx::none_of(at.hit)) return out;
    at.direction = rays.direction, at.gradient = hits.gradient;
    const FloatV t = select<FloatV>(at.hit, hits.t, FloatV(0.0f));
    points_on(rays, t, at);
    if (wanted > Derivatives::first) out.sums.clear_derivatives();
    for (std::uint32_t m = 0; m < models_.size(); ++m) {
        RaysAtHits own = at;
        if (models_.size() > 1)
            own.hit =
                own.hit && FloatV([&](auto k) { return out.model[k] == m ? 1.0f : 0.0f; }) > 0.0f;
        if (stdx::any_of(own.hit)) blend_in(models_[m], wanted, own, out.sums, counts);
    }
    average(at, hits.t, out);
    for (std::uint64_t bits = lane_bits(at.hit); bits != 0; bits &= bits - 1) {
        const int lane = std::countr_zero(bits);
        const auto k = static_cast<std::size_t>(lane);
        out.record[k] = record_at(hits, lane);
        out.clearance[k] = models_[out.model[k]].records[out.record[k]].clearance;
    }
    return out;
}

FloatV::mask_type TraceScene::unblocked(const RayPacket& rays, TraceCounts& counts) const {
    FloatV far = rays.far;
    for (const TraceModel& model : models_)
        counts.nodes_visited += for_leaves_along(model.bvh, rays, far, [&](const BvhNode& leaf) {
            for (std::uint32_t k = 0; k < leaf.n_items; ++k)
                if (surfel_hits(model, leaf.first + k, rays, EndAtAny{far}))
                    counts.root_tests += kLanes;
        });
    counts.rays += static_cast<std::uint64_t>(stdx::popcount(rays.active()));
    return rays.active() && far >= 0.0f;
}

}  // namespace slim
