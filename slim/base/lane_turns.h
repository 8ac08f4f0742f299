#pragma once

#include "slim/base/simd.h"

#include <array>
#include <bit>
#include <cstddef>
#include <utility>

namespace slim {

/// Lane k of the result is op over the lanes of v[k]; op is one like max, of two vectors.
template <class Op>
[[gnu::always_inline]] inline FloatV reduce_each(std::array<FloatV, kLanes> v, const Op& op) {
    using Raw [[gnu::vector_size(sizeof(FloatV))]] = float;
    // Each step halves what is left of every vector and joins two of them.
#pragma GCC unroll 8
    for (std::size_t n = kLanes / 2; n > 0; n /= 2)
#pragma GCC unroll 16
        for (std::size_t k = 0; k < n; ++k) {
            const Raw a = std::bit_cast<Raw>(v[2 * k]), b = std::bit_cast<Raw>(v[2 * k + 1]);
            v[k] = [&]<int... Lane>(std::integer_sequence<int, Lane...>)
                __attribute__((always_inline)) {
                return op(
                    std::bit_cast<FloatV>(Raw(__builtin_shufflevector(a, b, (2 * Lane)...))),
                    std::bit_cast<FloatV>(Raw(__builtin_shufflevector(a, b, (2 * Lane + 1)...))));
            }
            (std::make_integer_sequence<int, kLanes>{});
        }
    return v[0];
}

/// Swaps the quarters off the diagonal of all squares of rows of size 2 Half.
template <int Half>
[[gnu::always_inline]] inline void swap_quarters(std::array<FloatV, kLanes>& v) {
    using Raw [[gnu::vector_size(sizeof(FloatV))]] = float;
#pragma GCC unroll 16
    for (std::size_t k = 0; k < kLanes; ++k) {
        if (k & Half) continue;
        const Raw a = std::bit_cast<Raw>(v[k]), b = std::bit_cast<Raw>(v[k + Half]);
        [&]<int... Lane>(std::integer_sequence<int, Lane...>) __attribute__((always_inline)) {
            v[k] = std::bit_cast<FloatV>(Raw(__builtin_shufflevector(
                a, b, (Lane & Half ? kLanes + Lane - Half : Lane)...)));
            v[k + Half] = std::bit_cast<FloatV>(Raw(__builtin_shufflevector(
                a, b, (Lane & Half ? kLanes + Lane : Lane + Half)...)));
        }
        (std::make_integer_sequence<int, kLanes>{});
    }
}

/// Lane j of row i and lane i of row j change places.
[[gnu::always_inline]] inline void turn(std::array<FloatV, kLanes>& v) {
    static_assert(kLanes <= 16);
    if constexpr (kLanes >= 16) swap_quarters<8>(v);
    if constexpr (kLanes >= 8) swap_quarters<4>(v);
    if constexpr (kLanes >= 4) swap_quarters<2>(v);
    if constexpr (kLanes >= 2) swap_quarters<1>(v);
}

/// Writes a[k] b[k] c[k] d[k] to to(k), a place for four floats, for every lane k.
template <class To>
[[gnu::always_inline]] inline void store_fours(const LanesOfDouble<float>& a,
                                               const LanesOfDouble<float>& b,
                                               const LanesOfDouble<float>& c,
                                               const LanesOfDouble<float>& d, const To& to) {
    // Intrinsics outside simd.h: no std::simd turns four rows into eight columns in registers.
#ifdef __AVX512VL__
    const auto lo = [](const LanesOfDouble<float>& x, const LanesOfDouble<float>& y)
        __attribute__((always_inline)) {
        return _mm256_castps_pd(_mm256_unpacklo_ps(static_cast<__m256>(x), static_cast<__m256>(y)));
    };
    const auto hi = [](const LanesOfDouble<float>& x, const LanesOfDouble<float>& y)
        __attribute__((always_inline)) {
        return _mm256_castps_pd(_mm256_unpackhi_ps(static_cast<__m256>(x), static_cast<__m256>(y)));
    };
    const __m256d ab_lo = lo(a, b), ab_hi = hi(a, b), cd_lo = lo(c, d), cd_hi = hi(c, d);
    // Half h of the k-th is lane 4 h + k.
    const __m256d fours[] = {_mm256_unpacklo_pd(ab_lo, cd_lo), _mm256_unpackhi_pd(ab_lo, cd_lo),
                             _mm256_unpacklo_pd(ab_hi, cd_hi), _mm256_unpackhi_pd(ab_hi, cd_hi)};
    for (std::size_t k = 0; k < 4; ++k) {
        const __m256 four = _mm256_castpd_ps(fours[k]);
        _mm_storeu_ps(to(k), _mm256_castps256_ps128(four));
        _mm_storeu_ps(to(k + 4), _mm256_extractf128_ps(four, 1));
    }
#else
    for (std::size_t k = 0; k < LanesOfDouble<float>::size(); ++k) {
        float* out = to(k);
        out[0] = a[k], out[1] = b[k], out[2] = c[k], out[3] = d[k];
    }
#endif
}

}  // namespace slim
