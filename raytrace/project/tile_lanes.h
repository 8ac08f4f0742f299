#pragma once

#include "raytrace/intersect/ray_kernel.h"
#include "raytrace/project/tile_buffers.h"
#include "slim/blend/blend.h"
#include "slim/model/rim.h"

#include <array>
#include <cstddef>

namespace slim {

/// A surfel's rims in floats.
struct RimLanes {
    struct Line {
        float u, v, reach;
        explicit Line(PackedRim packed) {
            const Rim rim = unpack_rim(packed);
            u = static_cast<float>(rim.u), v = static_cast<float>(rim.v);
            // None: beyond all that lies in a ball, and finite in the sums below.
            reach = rim.is_whole() ? 1e3f : static_cast<float>(rim.reach);
        }
        [[gnu::always_inline]] FloatV inside(const FloatV& x, const FloatV& y) const {
            return FloatV(reach) - FloatV(u) * x - FloatV(v) * y;
        }
    };
    Line first, second;
    bool is_whole;

    explicit RimLanes(PackedRims packed)
        : first(packed.first), second(packed.second), is_whole(!packed.any()) {}
    /// rim_share at some places; the surfel has a rim.
    [[gnu::always_inline]] FloatV share(const FloatV& x, const FloatV& y) const {
        constexpr float kPerRamp = static_cast<float>(1 / kRimRamp);
        const FloatV inside = stdx::min(first.inside(x, y), second.inside(x, y)) * FloatV(kPerRamp);
        return stdx::min(stdx::max(inside, FloatV(0.0f)), FloatV(1.0f));
    }
};

[[gnu::always_inline]] inline void store_where(TilePlane& plane, std::size_t i, const FloatV::mask_type& where,
                                               const FloatV& x) {
    stdx::where(where, x).copy_to(plane.v + i, stdx::element_aligned);
}

/// Writes hits that are nearer than what some lanes have.
[[gnu::always_inline]] inline void keep_nearer(TileBuffers& t, std::size_t i, float entry,
                                               const FloatV::mask_type& nearer, const FloatV& z,
                                               const GradientLanes<FloatV>& g, const TileSums& sums) {
    store_where(t.z, i, nearer, z);
    store_where(t.gx, i, nearer, g.x);
    store_where(t.gy, i, nearer, g.y);
    store_where(t.gz, i, nearer, g.z);
    if (sums.node) store_where(t.winner, i, nearer, FloatV(entry));
}

/// Lanes whose gradient agrees with that of q^ (NUMERICS 4.4), in a model with sharp surfels closely (Gate in
/// slim/blend/blend.h).
template <bool kSharpModel>
[[gnu::always_inline]] inline FloatV::mask_type admitted(const GradientLanes<FloatV>& g, std::size_t i,
                                                         const TileBuffers& t) {
    const FloatV x = t.gx.load(i), y = t.gy.load(i), z = t.gz.load(i);
    const FloatV agreement = g.x * x + g.y * y + g.z * z;
    if constexpr (!kSharpModel) return agreement > 0.0f;
    const FloatV size = stdx::sqrt((g.x * g.x + g.y * g.y + g.z * g.z) * (x * x + y * y + z * z));
    return agreement > static_cast<float>(kSharpGate) * size;
}

/// weight_kernel for what is blended, s < 1: exp(-8 s) on [0, 1/4] by a polynomial of degree 6, interpolated at
/// Chebyshev's points, and a quick root; absolute error below 3e-6.
[[gnu::always_inline]] inline FloatV blend_weight(const FloatV& s) {
    const FloatV sq_s = s * s;
    const FloatV low = 0.999998668f - 7.99947649f * s, middle = 31.9660136f - 84.4941842f * s;
    const FloatV high = 160.585256f + s * (138.185089f * s - 208.353479f);
    const FloatV e = low + sq_s * (middle + sq_s * high);
    const FloatV rest = 1.0f - s * inverse_sqrt(s);
    const FloatV sq = rest * rest;
    return select<FloatV>(s <= 0.25f, e, 2.16536453f * (sq * sq));
}

/// Adds the roots of some lanes to the sums, each with its share of G; depths are averaged as differences from q^,
/// where floats are finest.
template <class Hessian>
[[gnu::always_inline]] inline void add_to_sums(TileBuffers& t, std::size_t i, const FloatV::mask_type& taken,
                                               const FloatV& share, const FloatV& sq_distance, const FloatV& dz,
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
