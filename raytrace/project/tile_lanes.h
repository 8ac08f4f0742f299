#pragma once

#include "raytrace/intersect/blend_lanes.h"
#include "raytrace/intersect/ray_kernel.h"
#include "raytrace/project/tile_buffers.h"
#include "slim/blend/blend.h"

#include <cstddef>

namespace slim {

[[gnu::always_inline]] inline void store_where(TilePlane& plane, std::size_t i,
                                               const FloatV::mask_type& where, const FloatV& x) {
    stdx::where(where, x).copy_to(plane.v + i, stdx::element_aligned);
}

/// Writes hits that are nearer than what some lanes have.
[[gnu::always_inline]] inline void keep_nearer(TileBuffers& t, std::size_t i, float entry,
                                               const FloatV::mask_type& nearer, const FloatV& z,
                                               const GradientLanes<FloatV>& g,
                                               const TileSums& sums) {
    store_where(t.z, i, nearer, z);
    store_where(t.gx, i, nearer, g.x);
    store_where(t.gy, i, nearer, g.y);
    store_where(t.gz, i, nearer, g.z);
    if (sums.node) store_where(t.winner, i, nearer, FloatV(entry));
}

/// Lanes whose gradient agrees with that of q^ (NUMERICS 4.4), in a model with sharp surfels
/// closely (Gate in slim/blend/blend.h).
template <bool kSharpModel>
[[gnu::always_inline]] inline FloatV::mask_type admitted(const GradientLanes<FloatV>& g,
                                                         std::size_t i, const TileBuffers& t) {
    const FloatV x = t.gx.load(i), y = t.gy.load(i), z = t.gz.load(i);
    const FloatV agreement = g.x * x + g.y * y + g.z * z;
    if constexpr (!kSharpModel) return agreement > 0.0f;
    const FloatV size = stdx::sqrt((g.x * g.x + g.y * g.y + g.z * g.z) * (x * x + y * y + z * z));
    return agreement > static_cast<float>(kSharpGate) * size;
}

/// Adds the weights of a surfel that rays pass over at q^.
[[gnu::always_inline]] inline void add_passing(TileBuffers& t, std::size_t i,
                                               const FloatV::mask_type& passed,
                                               const FloatV& share, const FloatV& sq_distance) {
    t.passing.add(i, select<FloatV>(passed, share * blend_weight(sq_distance), FloatV(0.0f)));
}

/// Adds the roots of some lanes to the sums, each with its share of G; depths are averaged as
/// differences from q^, where floats are finest.
template <class Hessian>
[[gnu::always_inline]] inline void add_to_sums(TileBuffers& t, std::size_t i,
                                               const FloatV::mask_type& taken, const FloatV& share,
                                               const FloatV& sq_distance, const FloatV& dz,
                                               const GradientLanes<FloatV>& g, const TileSums& sums,
                                               Hessian&& add_hessian) {
    const FloatV zero(0.0f);
    const FloatV w = select<FloatV>(taken, share * blend_weight(sq_distance), zero);
    t.weight.add(i, w);
    t.sum_x.add(i, w * g.x);
    t.sum_y.add(i, w * g.y);
    t.sum_z.add(i, w * g.z);
    if (sums.depth) t.offset.add(i, w * select<FloatV>(taken, dz, zero));
    if (sums.count) t.count.add(i, select<FloatV>(taken, FloatV(1.0f), zero));
    add_hessian(w);
}

}  // namespace slim
