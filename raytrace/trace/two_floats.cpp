#include "raytrace/trace/two_floats.h"

#include "slim/base/simd.h"

// Built without contraction of products and sums (CMakeLists.txt): a sum that swallowed a product
// unrounded would not be the one whose error is told.

namespace slim {
namespace {

/// a + b, exactly (Knuth).
[[gnu::always_inline]] inline TwoFloats exact_sum(const FloatV& a, const FloatV& b) {
    const FloatV sum = a + b, back = sum - a;
    return {sum, (a - (sum - back)) + (b - back)};
}

[[gnu::always_inline]] inline TwoFloats number_along(const TwoFloats& o, const TwoFloats& d,
                                                     const FloatV& t) {
    const FloatV product = t * d.high,
                 product_low = lanes_fma<FloatV>(t, d.high, -product) + t * d.low;
    const TwoFloats sum = exact_sum(o.high, product);
    return exact_sum(sum.high, sum.low + (product_low + o.low));
}

}  // namespace

TwoFloats sum_of(const TwoFloats& a, const TwoFloats& b) {
    const TwoFloats high = exact_sum(a.high, b.high);
    return exact_sum(high.high, high.low + (a.low + b.low));
}

TwoFloatVecs place_along(const TwoFloatVecs& o, const TwoFloatVecs& d, const FloatV& t) {
    const TwoFloats x = number_along({o.high.x, o.low.x}, {d.high.x, d.low.x}, t);
    const TwoFloats y = number_along({o.high.y, o.low.y}, {d.high.y, d.low.y}, t);
    const TwoFloats z = number_along({o.high.z, o.low.z}, {d.high.z, d.low.z}, t);
    return {{x.high, y.high, z.high}, {x.low, y.low, z.low}};
}

TwoFloatVecs scaled_sum(const TwoFloatVecs& a, const TwoFloatVecs& b, const FloatV& s) {
    const TwoFloats x = sum_of({a.high.x, a.low.x}, {b.high.x, b.low.x});
    const TwoFloats y = sum_of({a.high.y, a.low.y}, {b.high.y, b.low.y});
    const TwoFloats z = sum_of({a.high.z, a.low.z}, {b.high.z, b.low.z});
    return {LanesOfVec{x.high, y.high, z.high} * s, LanesOfVec{x.low, y.low, z.low} * s};
}

}  // namespace slim
