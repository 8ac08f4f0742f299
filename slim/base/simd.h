#pragma once

#include <experimental/simd>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#ifdef __AVX512VL__
#include <immintrin.h>
#endif

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

/// Lanes of T, as many as there are native ones of double.
template <class T>
using LanesOfDouble = stdx::simd<T, stdx::simd_abi::deduce_t<T, stdx::native_simd<double>::size()>>;

/// Writes the lanes of v whose bit is set side by side to out, which has room for all lanes; what
/// it holds after the chosen ones is not defined. T is float, double or std::uint32_t.
template <class T>
inline void compress_to(const LanesOfDouble<T>& v, std::uint64_t bits, T* out) {
    // The one place without lanes of the standard library, which cannot do it: a loop over the bits
    // made gathering a ball half as slow again.
#ifdef __AVX512VL__
    const auto mask = static_cast<__mmask8>(bits);
    if constexpr (std::is_same_v<T, double>)
        _mm512_storeu_pd(out, _mm512_maskz_compress_pd(mask, static_cast<__m512d>(v)));
    else if constexpr (std::is_same_v<T, float>)
        _mm256_storeu_ps(out, _mm256_maskz_compress_ps(mask, static_cast<__m256>(v)));
    else
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(out),
                            _mm256_maskz_compress_epi32(mask, static_cast<__m256i>(v)));
#else
    for (; bits != 0; bits &= bits - 1)
        *out++ = v[static_cast<std::size_t>(std::countr_zero(bits))];
#endif
}

/// The same for as many floats as one instruction works on.
inline void compress_to(const FloatV& v, std::uint64_t bits, float* out) {
#ifdef __AVX512VL__
    _mm512_storeu_ps(
        out, _mm512_maskz_compress_ps(static_cast<__mmask16>(bits), static_cast<__m512>(v)));
#else
    for (; bits != 0; bits &= bits - 1)
        *out++ = v[static_cast<std::size_t>(std::countr_zero(bits))];
#endif
}

}  // namespace slim
