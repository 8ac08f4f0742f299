#pragma once

#include "raytrace/lanes_of_vec.h"

namespace slim {

/// Numbers in two floats each: rounded values and what they lack.
struct TwoFloats {
    FloatV high, low;
};

/// a + b, to a few units of the second float; exactly, if neither has one.
TwoFloats sum_of(const TwoFloats& a, const TwoFloats& b);

/// Vectors in two floats each: rounded values and what they lack.
struct TwoFloatVecs {
    LanesOfVec high, low;
};

/// o + t d per lane: a place on a ray, to a few units of the second float.
TwoFloatVecs place_along(const TwoFloatVecs& o, const TwoFloatVecs& d, const FloatV& t);

/// (a + b) s, as exact; s is a power of two.
TwoFloatVecs scaled_sum(const TwoFloatVecs& a, const TwoFloatVecs& b, const FloatV& s);

}  // namespace slim
