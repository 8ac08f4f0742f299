#pragma once

#include "raytrace/intersect/sharp_kernel.h"
#include "raytrace/project/draw_list.h"
#include "raytrace/project/tile_buffers.h"
#include "slim/blend/blend.h"
#include "slim/model/surfel.h"
#include "slim/model/weight_kernel.h"

#include <algorithm>
#include <cstdint>
#include <span>

namespace slim {

/// Calls visit(tile_y, group) for the groups of lanes of a tile that a rectangle touches.
template <class Visit>
inline void for_each_group(const TileBuffers& t, const ScreenRect& r, Visit&& visit) {
    const ScreenRect& c = t.clip;
    const int y0 = std::max(r.y0, c.y0) - t.y0, y1 = std::min(r.y1, c.y1) - t.y0;
    const int x0 = std::max(r.x0, c.x0) - t.x0, x1 = std::min(r.x1, c.x1) - t.x0;
    if (x0 >= x1) return;
    const int group_0 = x0 / kLanes, group_1 = (x1 - 1) / kLanes;
    for (int y = y0; y < y1; ++y)
        for (int group = group_0; group <= group_1; ++group) visit(y, group);
}

/// A record's depths relative to the tile's reference.
struct RecordDepths {
    float base, center;
    RecordDepths(const DrawRecord& r, const TileBuffers& t)
        : base(static_cast<float>(r.z_base - t.z_ref)),
          center(static_cast<float>(r.z_center - t.z_ref)) {}
};

// The four functions that work on a group are flattened: g++ 12 leaves out some of their calls as they grow, and a
// frame took twice as long.

/// A surfel's rims in floats.
struct RimLanes {
    struct Line {
        float u, v, reach;
        explicit Line(PackedRim packed) {
            const Rim rim = unpack_rim(packed);
            u = static_cast<float>(rim.u), v = static_cast<float>(rim.v);
            // Whole discs: beyond all that lies in a ball, and finite in the sums below.
            reach = rim.is_whole() ? 1e3f : static_cast<float>(rim.reach);
        }
        FloatV inside(const FloatV& x, const FloatV& y) const { return reach - u * x - v * y; }
    };
    Line first, second;

    explicit RimLanes(PackedRims packed) : first(packed.first), second(packed.second) {}
    /// rim_share at some places.
    FloatV share(const FloatV& x, const FloatV& y) const {
        constexpr float kPerRamp = static_cast<float>(1 / kRimRamp);
        const FloatV inside = stdx::min(first.inside(x, y), second.inside(x, y));
        return stdx::clamp(inside * kPerRamp, FloatV(0.0f), FloatV(1.0f));
    }
};

/// Writes hits that are nearer than what a group has.
inline void keep_nearer(TileBuffers& t, std::size_t i, float entry, const FloatV::mask_type& nearer,
                        const FloatV& z, const GradientLanes<FloatV>& g) {
    t.z.store(i, select<FloatV>(nearer, z, t.z.load(i)));
    t.winner.store(i, select<FloatV>(nearer, FloatV(entry), t.winner.load(i)));
    t.gx.store(i, select<FloatV>(nearer, g.x, t.gx.load(i)));
    t.gy.store(i, select<FloatV>(nearer, g.y, t.gy.load(i)));
    t.gz.store(i, select<FloatV>(nearer, g.z, t.gz.load(i)));
}

/// Stage 1 for one surfel and one group: first root inside the shrunken ball, kept if nearer.
template <int Degree>
[[gnu::flatten]] inline void first_hits(const DrawRecord& r, const RimLanes& rim, float entry,
                       const RecordDepths& depth, int tile_y, int group, TileBuffers& t) {
    constexpr float kSqTrim = static_cast<float>(kHitTrim * kHitTrim);
    const std::size_t i = group_index(tile_y, group);
    const PixelRays<FloatV> rays = t.rays(tile_y, group);
    const BallRay<FloatV> ball = ball_ray(r, rays);
    const FloatV z = t.z.load(i);
    const float nearest = depth.center - static_cast<float>(kHitTrim) * r.radius;
    const auto active = ball.sq_distance < kSqTrim && z > nearest;
    if (stdx::none_of(active)) return;
    t.counts.root_tests += static_cast<std::uint64_t>(stdx::popcount(active));
    const FloatV s = stdx::sqrt(stdx::max(kSqTrim - ball.sq_distance, FloatV(0.0f)));
    const FloatV at_near = (t.near_z - depth.base) * r.inv_radius * rays.inv_dz + ball.along;
    const SurfelRay<FloatV> ray = surfel_ray(r, rays, ball);
    const auto root = first_root<Degree, FloatV>(ray_polynomial<Degree>(r, ray),
                                                 stdx::max(-s, at_near), s, active);
    const FloatV z_root = depth.base + r.radius * (root.t - ball.along) * rays.dz;
    const FloatV u = ray.bu + root.t * ray.du, v = ray.bv + root.t * ray.dv;
    const auto nearer = root.hit && z_root < z && rim.share(u, v) > 0.0f;
    if (stdx::none_of(nearer)) return;
    const auto g = gradient_at<Degree, FloatV>(r, u, v);
    keep_nearer(t, i, entry, nearer, z_root, g);
}

/// The same for a sharp surfel: the first root of its joined function.
template <int Degree>
[[gnu::flatten]] inline void first_sharp_hits(const SharpRecord& s, float entry, const RecordDepths& depth,
                             int tile_y, int group, TileBuffers& t) {
    constexpr float kSqTrim = static_cast<float>(kHitTrim * kHitTrim);
    const DrawRecord& r = s.sheet[0];
    const std::size_t i = group_index(tile_y, group);
    const PixelRays<FloatV> rays = t.rays(tile_y, group);
    const BallRay<FloatV> ball = ball_ray(r, rays);
    const auto active = ball.sq_distance < kSqTrim;
    if (stdx::none_of(active)) return;
    t.counts.root_tests += s.n_sheets * static_cast<std::uint64_t>(stdx::popcount(active));
    const FloatV half = stdx::sqrt(stdx::max(kSqTrim - ball.sq_distance, FloatV(0.0f)));
    const FloatV at_near = (t.near_z - depth.base) * r.inv_radius * rays.inv_dz + ball.along;
    const SharpRays<FloatV> f = sharp_rays<Degree>(s, rays, ball);
    const auto found = best_joined_root<Degree, FloatV>(
        s, f, stdx::max(-half, at_near), half, active, [](const FloatV& x) { return x; });
    const FloatV z_root = depth.base + r.radius * (found.root.t - ball.along) * rays.dz;
    const auto nearer = found.root.hit && z_root < t.z.load(i);
    if (stdx::none_of(nearer)) return;
    keep_nearer(t, i, entry, nearer, z_root, sharp_gradient<Degree, FloatV>(s, f, found));
}

/// Lanes whose gradient agrees with that of q^ (NUMERICS 4.4), in a model with sharp surfels closely (Gate in
/// slim/blend/blend.h).
template <bool kSharpModel>
inline FloatV::mask_type admitted(const GradientLanes<FloatV>& g, std::size_t i,
                                  const TileBuffers& t) {
    const FloatV x = t.gx.load(i), y = t.gy.load(i), z = t.gz.load(i);
    const FloatV agreement = g.x * x + g.y * y + g.z * z;
    if constexpr (!kSharpModel) return agreement > 0.0f;
    const FloatV size = stdx::sqrt((g.x * g.x + g.y * g.y + g.z * g.z) * (x * x + y * y + z * z));
    return agreement > static_cast<float>(kSharpGate) * size;
}

/// Lanes whose root is near enough to q^ to be the same sheet (add_supporter in slim/blend).
inline FloatV::mask_type belongs(const FloatV& root, const FloatV& guess) {
    return stdx::abs(root - guess) <= static_cast<float>(kBelongs);
}

/// Adds roots of one group to the sums, each with its share of G; depths are averaged as differences from q^, where floats are finest.
template <class Hessian>
inline void add_to_sums(TileBuffers& t, std::size_t i, const FloatV::mask_type& taken,
                        const FloatV& share, const FloatV& sq_distance, const FloatV& dz, const GradientLanes<FloatV>& g,
                        Hessian&& add_hessian) {
    const FloatV zero(0.0f);
    const FloatV w = select<FloatV>(taken, share * weight_kernel<FloatV>(sq_distance), zero);
    t.weight.add(i, w);
    t.offset.add(i, w * select<FloatV>(taken, dz, zero));
    t.count.add(i, select<FloatV>(taken, FloatV(1.0f), zero));
    t.sum_x.add(i, w * g.x);
    t.sum_y.add(i, w * g.y);
    t.sum_z.add(i, w * g.z);
    add_hessian(w);
}

/// One group's q^ seen from a surfel.
struct GuessInBall {
    PixelRays<FloatV> rays;
    BallRay<FloatV> ball;
    FloatV guess;               // its parameter on the surfel's local ray
    FloatV half;                // of the chord in the ball
    FloatV::mask_type inside;   // lanes whose q^ lies in the ball
};
inline GuessInBall guess_in_ball(const DrawRecord& r, const RecordDepths& depth, int tile_y,
                                 int group, TileBuffers& t) {
    const PixelRays<FloatV> rays = t.rays(tile_y, group);
    const BallRay<FloatV> ball = ball_ray(r, rays);
    const FloatV z = t.z.load(group_index(tile_y, group));
    const FloatV tau = (z - depth.base) * r.inv_radius * rays.inv_dz;
    t.counts.distance_tests += kLanes;
    return {rays, ball, tau + ball.along,
            stdx::sqrt(stdx::max(1.0f - ball.sq_distance, FloatV(0.0f))),
            ball.sq_distance_at(r, rays, tau) < 1.0f};
}

/// Stage 2 for one surfel and one group: eqs (6) and (7) around q^, with the gates of add_supporter
/// (slim/blend).
template <int Degree, bool kWantHessian, bool kSharpModel, bool kWantThird>
[[gnu::flatten]] inline void blend(const DrawRecord& r, const RimLanes& rim, const RecordDepths& depth, int tile_y,
                  int group, TileBuffers& t) {
    const std::size_t i = group_index(tile_y, group);
    const auto [rays, ball, guess, s, inside] = guess_in_ball(r, depth, tile_y, group, t);
    if (stdx::none_of(inside)) return;
    t.counts.root_tests += static_cast<std::uint64_t>(stdx::popcount(inside));
    const SurfelRay<FloatV> ray = surfel_ray(r, rays, ball);
    const auto root =
        nearest_root<Degree, FloatV>(ray_polynomial<Degree>(r, ray), guess, s, inside);
    const FloatV u = ray.bu + root.t * ray.du, v = ray.bv + root.t * ray.dv;
    const auto g = gradient_at<Degree, FloatV>(r, u, v);
    const FloatV share = rim.share(u, v);
    const auto taken =
        root.hit && belongs(root.t, guess) && share > 0.0f && admitted<kSharpModel>(g, i, t);
    if (stdx::none_of(taken)) return;
    const FloatV dz = r.radius * rays.dz * (root.t - guess);
    add_to_sums(t, i, taken, share, ball.sq_distance + root.t * root.t, dz, g, [&](const FloatV& w) {
        if constexpr (!kWantHessian) return;
        const auto h = hessian_at<Degree, FloatV>(r, u, v);
        for (std::size_t k = 0; k < 6; ++k) t.hessian[k].add(i, w * h[k]);
        if constexpr (!kWantThird) return;
        const auto c = third_of(r);
        for (std::size_t k = 0; k < 10; ++k) t.third[k].add(i, w * c[k]);
    });
}

/// The same for a sharp surfel: the root of its joined function nearest q^.
template <int Degree, bool kWantHessian, bool kWantThird>
[[gnu::flatten]] inline void blend_sharp(const SharpRecord& s, const RecordDepths& depth, int tile_y, int group,
                        TileBuffers& t) {
    const DrawRecord& r = s.sheet[0];
    const std::size_t i = group_index(tile_y, group);
    const auto [rays, ball, guess, half, inside] = guess_in_ball(r, depth, tile_y, group, t);
    if (stdx::none_of(inside)) return;
    t.counts.root_tests += s.n_sheets * static_cast<std::uint64_t>(stdx::popcount(inside));
    const SharpRays<FloatV> f = sharp_rays<Degree>(s, rays, ball);
    const auto found = best_joined_root<Degree, FloatV>(
        s, f, -half, half, inside, [q = guess](const FloatV& x) { return stdx::abs(x - q); });
    const auto g = sharp_gradient<Degree, FloatV>(s, f, found);
    const auto taken =
        found.root.hit && belongs(found.root.t, guess) && admitted<true>(g, i, t);
    if (stdx::none_of(taken)) return;
    const FloatV& x = found.root.t;
    add_to_sums(t, i, taken, FloatV(1.0f), ball.sq_distance + x * x, r.radius * rays.dz * (x - guess), g,
                [&](const FloatV& w) {
                    if constexpr (!kWantHessian) return;
                    const auto h = sharp_hessian<Degree, FloatV>(s, f, found);
                    for (std::size_t k = 0; k < 6; ++k) t.hessian[k].add(i, w * h[k]);
                    if constexpr (!kWantThird) return;
                    const auto c = sharp_third<FloatV>(s, found);
                    for (std::size_t k = 0; k < 10; ++k) t.third[k].add(i, w * c[k]);
                });
}

/// Stage 1 of a tile: its surfels, nearest first; one behind everything is passed over.
template <int Degree, bool kSharpModel>
void run_stage_1(const DrawList& list, std::span<const std::uint32_t> entries, TileBuffers& t) {
    constexpr std::size_t kUpdateEvery = 8;
    float farthest = t.farthest();
    for (std::size_t e = 0; e < entries.size(); ++e) {
        const DrawRecord& r = list.records[entries[e]];
        const RecordDepths depth(r, t);
        if (e % kUpdateEvery == 0) farthest = t.farthest();
        if (depth.center - static_cast<float>(kHitTrim) * r.radius > farthest) continue;
        const auto entry = static_cast<float>(e);
        if constexpr (kSharpModel)
            if (const SharpRecord* s = list.sharp_at(entries[e])) {
                for_each_group(t, list.trimmed[entries[e]], [&](int y, int group) {
                    first_sharp_hits<Degree>(*s, entry, depth, y, group, t);
                });
                continue;
            }
        const RimLanes rim(list.rims[entries[e]]);
        for_each_group(t, list.trimmed[entries[e]], [&](int y, int group) {
            first_hits<Degree>(r, rim, entry, depth, y, group, t);
        });
    }
}

/// Stage 2 of a tile. A group is skipped if the ball cannot reach the depths of its q^.
template <int Degree, bool kWantHessian, bool kSharpModel, bool kWantThird = false>
void run_stage_2(const DrawList& list, std::span<const std::uint32_t> entries, TileBuffers& t) {
    if (!t.update_group_ranges()) return;
    for (const std::uint32_t entry : entries) {
        const DrawRecord& r = list.records[entry];
        const RecordDepths depth(r, t);
        const RimLanes rim(list.rims[entry]);
        // A little more than the radius, for the rounding of the depths.
        const float reach = r.radius * 1.0001f;
        for_each_group(t, list.full[entry], [&](int y, int group) {
            const auto g = static_cast<std::size_t>(y * kGroupsPerRow + group);
            if (depth.center - reach > t.group_far[g] || depth.center + reach < t.group_near[g])
                return;
            if constexpr (kSharpModel)
                if (const SharpRecord* s = list.sharp_at(entry))
                    return blend_sharp<Degree, kWantHessian, kWantThird>(*s, depth, y, group, t);
            blend<Degree, kWantHessian, kSharpModel, kWantThird>(r, rim, depth, y, group, t);
        });
    }
}

}  // namespace slim
