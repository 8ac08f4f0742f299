#pragma once

#include "slim/base/simd.h"
#include "slim/model/rim.h"

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

/// weight_kernel for what is blended, s < 1: exp(-8 s) on [0, 1/4] by a polynomial of degree 6,
/// interpolated at Chebyshev's points, and a quick root; absolute error below 3e-6.
[[gnu::always_inline]] inline FloatV blend_weight(const FloatV& s) {
    const FloatV sq_s = s * s;
    const FloatV low = 0.999998668f - 7.99947649f * s, middle = 31.9660136f - 84.4941842f * s;
    const FloatV high = 160.585256f + s * (138.185089f * s - 208.353479f);
    const FloatV e = low + sq_s * (middle + sq_s * high);
    const FloatV rest = 1.0f - s * inverse_sqrt(s);
    const FloatV sq = rest * rest;
    return select<FloatV>(s <= 0.25f, e, 2.16536453f * (sq * sq));
}

}  // namespace slim
