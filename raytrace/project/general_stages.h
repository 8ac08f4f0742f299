#pragma once

#include "raytrace/intersect/sharp_kernel.h"
#include "raytrace/project/tile_lanes.h"

#include <algorithm>
#include <cstdint>

namespace slim {

/// Calls visit(block) for the blocks of a tile that a rectangle touches, of some.
template <class Visit>
inline void for_each_block(TileBuffers& t, const ScreenRect& r, const BlockMask& of,
                           Visit&& visit) {
    const ScreenRect on = t.on_tile(r);
    if (on.empty() || !of.any()) return;
    for (int row = on.y0 / kBlockHeight; row * kBlockHeight < on.y1; ++row)
        for (int column = on.x0 / kBlockWidth; column * kBlockWidth < on.x1; ++column) {
            const int block = row * kBlockColumns + column;
            if (of.has(block)) visit(block);
            else
                ++t.counts.blocks_passed;
        }
}

// The general kernels, a ray set up for every pixel: sharp surfels, and smooth ones near the eye or
// far off the axis.

/// What the rim leaves at roots of a surfel of one sheet.
inline FloatV rim_share_at(const RimLanes& rim, const SharpRays<FloatV>& f, const FloatV& t) {
    if (rim.is_whole) return FloatV(1.0f);
    return rim.share(f.ray[0].bu + t * f.ray[0].du, f.ray[0].bv + t * f.ray[0].dv);
}

/// Stage 1: the first root of the joined function; kBehind: only behind last_z.
template <int Degree, bool kBehind = false>
[[gnu::flatten]] inline void first_general_hits(const SharpRecord& s, const RimLanes& rim,
                                                float entry, float base, int block,
                                                const TileSums& sums, TileBuffers& t) {
    const double trim = hit_trim(s.n_sheets > 1);
    const auto sq_trim = static_cast<float>(trim * trim);
    const DrawRecord& r = s.sheet[0];
    const auto i = static_cast<std::size_t>(block * kLanes);
    const PixelRays<FloatV> rays = t.rays(block);
    const BallRay<FloatV> ball = ball_ray(r, rays);
    const auto active = ball.sq_distance < sq_trim;
    if (stdx::none_of(active)) return;
    t.counts.root_tests += s.n_sheets * kLanes;
    const FloatV half = stdx::sqrt(stdx::max(sq_trim - ball.sq_distance, FloatV(0.0f)));
    const auto at_depth = [&](const FloatV& z) {
        return (z - base) * r.inv_radius * rays.inv_dz + ball.along;
    };
    FloatV least = stdx::max(-half, at_depth(FloatV(t.near_z)));
    if constexpr (kBehind)
        least = stdx::max(least, at_depth(t.depths.relative<FloatV>(t.last_z.load(i))) +
                                     static_cast<float>(kNextHit));
    const SharpRays<FloatV> f = sharp_rays<Degree>(s, rays, ball);
    const auto found = best_joined_root<Degree, FloatV>(
        s, f, least, half, active, [](const FloatV& x) { return x; });
    const FloatV z_root =
        t.depths.zeta<FloatV>(base + r.radius * (found.root.t - ball.along) * rays.dz);
    const auto nearer =
        found.root.hit && z_root < t.z.load(i) && rim_share_at(rim, f, found.root.t) > 0.0f;
    if (stdx::none_of(nearer)) return;
    keep_nearer(t, i, entry, nearer, z_root, sharp_gradient<Degree, FloatV>(s, f, found), sums);
}

/// A surfel's ball about q^ of a block's pixels.
struct GeneralAtHit {
    PixelRays<FloatV> rays;
    BallRay<FloatV> ball;
    FloatV tau;  ///< of q^, from b0
    FloatV::mask_type inside;

    GeneralAtHit(const DrawRecord& r, float base, int block, TileBuffers& t)
        : rays(t.rays(block)), ball(ball_ray(r, rays)) {
        const FloatV z = t.z.load(static_cast<std::size_t>(block * kLanes));
        tau = (t.depths.relative<FloatV>(z) - base) * r.inv_radius * rays.inv_dz;
        t.counts.distance_tests += kLanes;
        inside = ball.sq_distance_at(r, rays, tau) < 1.0f;
    }
    /// q^ from the point nearest the centre.
    FloatV guess() const { return tau + ball.along; }
    FloatV half_chord() const {
        return stdx::sqrt(stdx::max(1.0f - ball.sq_distance, FloatV(0.0f)));
    }
};

/// Of some lanes the root of the joined function nearest q^, inside the whole ball.
template <int Degree>
inline SharpRoot<FloatV> root_nearest(const SharpRecord& s, const SharpRays<FloatV>& f,
                                      const GeneralAtHit& at, const FloatV::mask_type& lanes) {
    const FloatV half = at.half_chord();
    return best_joined_root<Degree, FloatV>(
        s, f, -half, half, lanes, [q = at.guess()](const FloatV& x) { return stdx::abs(x - q); });
}

/// Stage 2: the root of the joined function nearest q^.
template <int Degree, bool kWantHessian, bool kSharpModel, bool kWantThird>
[[gnu::flatten]] inline void blend_general(const SharpRecord& s, const RimLanes& rim, float base,
                                           int block, const TileSums& sums,
                                           TileBuffers& t) {
    const DrawRecord& r = s.sheet[0];
    const auto i = static_cast<std::size_t>(block * kLanes);
    const GeneralAtHit at(r, base, block, t);
    if (stdx::none_of(at.inside)) return;
    t.counts.root_tests += s.n_sheets * kLanes;
    const SharpRays<FloatV> f = sharp_rays<Degree>(s, at.rays, at.ball);
    const auto found = root_nearest<Degree>(s, f, at, at.inside);
    const auto g = sharp_gradient<Degree, FloatV>(s, f, found);
    const FloatV& x = found.root.t;
    const FloatV away = x - at.guess(), share = rim_share_at(rim, f, x);
    const auto taken = found.root.hit && stdx::abs(away) <= static_cast<float>(kBelongs) &&
                       admitted<kSharpModel>(g, i, t) && share > 0.0f;
    if (stdx::none_of(taken)) return;
    add_to_sums(t, i, taken, share, at.ball.sq_distance + x * x, r.radius * at.rays.dz * away, g,
                sums, [&](const FloatV& w) {
                    if constexpr (!kWantHessian) return;
                    const auto h = sharp_hessian<Degree, FloatV>(s, f, found);
                    for (std::size_t k = 0; k < 6; ++k) t.hessian[k].add(i, w * h[k]);
                    if constexpr (!kWantThird) return;
                    const auto c = sharp_third<FloatV>(s, found);
                    for (std::size_t k = 0; k < 10; ++k) t.third[k].add(i, w * c[k]);
                });
}

/// Lanes where a sheet's gradient at a ray parameter is admitted.
template <int Degree, bool kSharpModel>
inline FloatV::mask_type admitted_by_any(const SharpRecord& s, const SharpRays<FloatV>& f,
                                         const FloatV& at, std::size_t i, const TileBuffers& t) {
    FloatV::mask_type any(false);
    for (std::size_t k = 0; k < s.n_sheets; ++k)
        any = any || admitted<kSharpModel>(
                         gradient_at<Degree, FloatV>(s.sheet[k], f.ray[k].bu + at * f.ray[k].du,
                                                     f.ray[k].bv + at * f.ray[k].dv),
                         i, t);
    return any;
}

/// Adds the weights of rays that pass over the surfel at q^ (passing_weight in slim/blend).
template <int Degree, bool kSharpModel>
[[gnu::flatten]] inline void pass_general(const SharpRecord& s, const RimLanes& rim, float base,
                                          int block, TileBuffers& t) {
    const DrawRecord& r = s.sheet[0];
    const auto i = static_cast<std::size_t>(block * kLanes);
    const GeneralAtHit at(r, base, block, t);
    if (stdx::none_of(at.inside)) return;
    const FloatV guess = at.guess();
    const SharpRays<FloatV> f = sharp_rays<Degree>(s, at.rays, at.ball);
    const auto above = at.inside && joined_value<FloatV>(s, f, guess) > 0.0f;
    if (stdx::none_of(above)) return;
    t.counts.root_tests += s.n_sheets * kLanes;
    const auto found = root_nearest<Degree>(s, f, at, above);
    const auto near =
        found.root.hit && stdx::abs(found.root.t - guess) <= static_cast<float>(kBelongs);
    const auto passed =
        above && !near && admitted_by_any<Degree, kSharpModel>(s, f, guess, i, t);
    add_passing(t, i, passed, rim_share_at(rim, f, guess),
                at.ball.sq_distance + guess * guess);
}

template <int Degree>
void draw_first_general(const SharpRecord& s, PackedRims packed, const ScreenRect& rect,
                        const BlockMask& of, float entry, const TileSums& sums, TileBuffers& t) {
    const auto base = static_cast<float>(s.sheet[0].z_base - t.depths.z_ref);
    const RimLanes rim(packed);
    for_each_block(t, rect, of, [&](int block) {
        first_general_hits<Degree>(s, rim, entry, base, block, sums, t);
    });
}

template <int Degree, bool kWantHessian, bool kSharpModel, bool kWantThird>
void draw_blend_general(const SharpRecord& s, PackedRims packed, const ScreenRect& rect,
                        const BlockMask& of, const TileSums& sums, TileBuffers& t) {
    const auto base = static_cast<float>(s.sheet[0].z_base - t.depths.z_ref);
    const RimLanes rim(packed);
    for_each_block(t, rect, of, [&](int block) {
        blend_general<Degree, kWantHessian, kSharpModel, kWantThird>(s, rim, base, block, sums, t);
    });
}

}  // namespace slim
