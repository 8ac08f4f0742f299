#pragma once

#include <experimental/simd>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
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
[[gnu::always_inline]] inline V select(const typename V::mask_type& mask, const V& a, const V& b) {
    V r = b;
    stdx::where(mask, r) = a;
    return r;
}
inline float select(bool mask, float a, float b) { return mask ? a : b; }
inline double select(bool mask, double a, double b) { return mask ? a : b; }

/// a b + c, rounded once, and size (>= 0) with the sign of the other (-0 counts as 0), always
/// inline: g++ 12 leaves stdx's own out of large kernels, with the lanes through memory.
template <class V>
[[gnu::always_inline]] inline V lanes_fma(const V& a, const V& b, const V& c) {
#ifdef __AVX512VL__
    if constexpr (std::is_same_v<V, stdx::native_simd<float>> && sizeof(V) == 64)
        return V(_mm512_fmadd_ps(static_cast<__m512>(a), static_cast<__m512>(b),
                                 static_cast<__m512>(c)));
    else
#endif
        return stdx::fma(a, b, c);
}
/// a b - c, rounded once; beside lanes_fma because g++ 12 makes an instruction of its own of a sign
/// that two products share.
template <class V>
[[gnu::always_inline]] inline V lanes_fms(const V& a, const V& b, const V& c) {
#ifdef __AVX512VL__
    if constexpr (std::is_same_v<V, stdx::native_simd<float>> && sizeof(V) == 64)
        return V(_mm512_fmsub_ps(static_cast<__m512>(a), static_cast<__m512>(b),
                                 static_cast<__m512>(c)));
    else
#endif
        return stdx::fma(a, b, -c);
}

/// c - a b, rounded once.
template <class V>
[[gnu::always_inline]] inline V lanes_fnma(const V& a, const V& b, const V& c) {
#ifdef __AVX512VL__
    if constexpr (std::is_same_v<V, stdx::native_simd<float>> && sizeof(V) == 64)
        return V(_mm512_fnmadd_ps(static_cast<__m512>(a), static_cast<__m512>(b),
                                  static_cast<__m512>(c)));
    else
#endif
        return stdx::fma(-a, b, c);
}
/// 1 / sqrt(x) and 1 / x of normal floats, relative error up to 2^-14 where the target has such
/// estimates.
template <class V>
[[gnu::always_inline]] inline V inverse_sqrt_estimate(const V& x) {
#ifdef __AVX512VL__
    if constexpr (std::is_same_v<V, stdx::native_simd<float>> && sizeof(V) == 64)
        return V(_mm512_rsqrt14_ps(static_cast<__m512>(x)));
    else
#endif
        return 1.0f / stdx::sqrt(x);
}
template <class V>
[[gnu::always_inline]] inline V reciprocal_estimate(const V& x) {
#ifdef __AVX512VL__
    if constexpr (std::is_same_v<V, stdx::native_simd<float>> && sizeof(V) == 64)
        return V(_mm512_rcp14_ps(static_cast<__m512>(x)));
    else
#endif
        return 1.0f / x;
}
/// 1 / sqrt(x) and 1 / x of normal floats to a few units in the last place, by the target's
/// estimates and one step of Newton: a third of the time of exact ones, which share one slow unit.
/// No finite number comes of x = 0 (nor of a square root below).
template <class V>
[[gnu::always_inline]] inline V inverse_sqrt(const V& x) {
#ifdef __AVX512VL__
    if constexpr (std::is_same_v<V, stdx::native_simd<float>> && sizeof(V) == 64) {
        const V y = inverse_sqrt_estimate(x);
        return y * (1.5f - (0.5f * x) * (y * y));
    } else
#endif
        return 1.0f / stdx::sqrt(x);
}
template <class V>
[[gnu::always_inline]] inline V reciprocal(const V& x) {
#ifdef __AVX512VL__
    if constexpr (std::is_same_v<V, stdx::native_simd<float>> && sizeof(V) == 64) {
        const V y = reciprocal_estimate(x);
        return y * (2.0f - x * y);
    } else
#endif
        return 1.0f / x;
}

template <class V>
[[gnu::always_inline]] inline V lanes_copysign(const V& size, const V& sign) {
    return select<V>(sign < 0.0f, -size, size);
}

/// Bit i is lane i of a mask. (The standard's interface has no such thing; libstdc++'s does.)
template <class M>
inline std::uint64_t lane_bits(const M& mask) {
    return mask.__to_bitset().to_ullong();
}

/// The lanes of some bits.
[[gnu::always_inline]] inline FloatV::mask_type lanes_of_bits(std::uint32_t bits) {
    return FloatV::mask_type::__from_bitset(bits);
}

/// Bits of the first n (at most as many as there are lanes) of bytes that are 0 or 1.
inline std::uint32_t bits_of_bytes(const std::uint8_t* bytes, std::size_t n) {
    const auto eight = [](std::uint64_t word) {  // byte j goes to bit 56 + j
        return static_cast<std::uint32_t>((word * 0x0102040810204080u) >> 56);
    };
    std::uint32_t bits = 0;
    std::size_t k = 0;
    for (; k + 8 <= n; k += 8) {
        std::uint64_t word;
        std::memcpy(&word, bytes + k, 8);
        bits |= eight(word) << k;
    }
    for (; k < n; ++k) bits |= std::uint32_t{bytes[k]} << k;
    return bits;
}

/// Writes a[0] b[0] c[0] d[0] a[1] b[1] ...: 4 kLanes floats.
inline void store_interleaved(const FloatV& a, const FloatV& b, const FloatV& c, const FloatV& d,
                              float* out) {
#ifdef __AVX512VL__
    const auto lo = [](const FloatV& x, const FloatV& y) {
        return _mm512_castps_pd(_mm512_unpacklo_ps(static_cast<__m512>(x), static_cast<__m512>(y)));
    };
    const auto hi = [](const FloatV& x, const FloatV& y) {
        return _mm512_castps_pd(_mm512_unpackhi_ps(static_cast<__m512>(x), static_cast<__m512>(y)));
    };
    const __m512d ab_lo = lo(a, b), ab_hi = hi(a, b), cd_lo = lo(c, d), cd_hi = hi(c, d);
    // Quarter q of p_k holds entry 4 q + k.
    const __m512 p_0 = _mm512_castpd_ps(_mm512_unpacklo_pd(ab_lo, cd_lo));
    const __m512 p_1 = _mm512_castpd_ps(_mm512_unpackhi_pd(ab_lo, cd_lo));
    const __m512 p_2 = _mm512_castpd_ps(_mm512_unpacklo_pd(ab_hi, cd_hi));
    const __m512 p_3 = _mm512_castpd_ps(_mm512_unpackhi_pd(ab_hi, cd_hi));
    const __m512 even_01 = _mm512_shuffle_f32x4(p_0, p_1, 0x88),
                 even_23 = _mm512_shuffle_f32x4(p_2, p_3, 0x88);
    const __m512 odd_01 = _mm512_shuffle_f32x4(p_0, p_1, 0xdd),
                 odd_23 = _mm512_shuffle_f32x4(p_2, p_3, 0xdd);
    _mm512_storeu_ps(out, _mm512_shuffle_f32x4(even_01, even_23, 0x88));
    _mm512_storeu_ps(out + 16, _mm512_shuffle_f32x4(odd_01, odd_23, 0x88));
    _mm512_storeu_ps(out + 32, _mm512_shuffle_f32x4(even_01, even_23, 0xdd));
    _mm512_storeu_ps(out + 48, _mm512_shuffle_f32x4(odd_01, odd_23, 0xdd));
#else
    for (std::size_t k = 0; k < kLanes; ++k)
        out[4 * k] = a[k], out[4 * k + 1] = b[k], out[4 * k + 2] = c[k], out[4 * k + 3] = d[k];
#endif
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
