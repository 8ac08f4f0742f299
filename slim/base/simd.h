#pragma once

#include <experimental/simd>

#include <cstdint>

namespace slim {

namespace stdx = std::experimental;

/// Lanes of float that one instruction of the target works on (16 with AVX-512, 8 with AVX2).
using FloatV = stdx::native_simd<float>;
inline constexpr int kLanes = static_cast<int>(FloatV::size());

/// A constant for a kernel over T, which is float, double or a value with lanes.
template <class T>
constexpr T constant(double c) {
    if constexpr (stdx::is_simd_v<T>)
        return T(static_cast<typename T::value_type>(c));
    else
        return static_cast<T>(c);
}

/// mask ? a : b, for values with lanes and for plain ones: a kernel is written once.
template <class V>
inline V select(const typename V::mask_type& mask, const V& a, const V& b) {
    V r = b;
    stdx::where(mask, r) = a;
    return r;
}
inline float select(bool mask, float a, float b) { return mask ? a : b; }
inline double select(bool mask, double a, double b) { return mask ? a : b; }

/// Bit i is lane i of a mask. (The standard's interface has no such thing; libstdc++'s does.)
template <class M>
inline std::uint64_t lane_bits(const M& mask) {
    return mask.__to_bitset().to_ullong();
}

}  // namespace slim
