#pragma once

#include "slim/base/simd.h"

#include <array>
#include <cstddef>
#include <type_traits>
#include <utility>

namespace slim {

/// Calls body(std::integral_constant) for 0 .. N - 1: loops that the compiler leaves rolled keep
/// their lanes in memory.
template <std::size_t N, class Body>
[[gnu::always_inline]] inline void for_constants(const Body& body) {
    [&]<std::size_t... K>(std::index_sequence<K...>) __attribute__((always_inline)) {
        (body(std::integral_constant<std::size_t, K>{}), ...);
    }
    (std::make_index_sequence<N>{});
}

/// The sum of the lanes of floats as doubles, by halves: lane after lane costs as much as the
/// points of a ball.
template <class V>
double lane_sum(const V& v) {
    if constexpr (std::is_same_v<typename V::value_type, double> || V::size() % 2 != 0) {
        return static_cast<double>(stdx::reduce(v));
    } else {
        using Half = LanesOfDouble<double>;
        const auto [low, high] = stdx::split<V::size() / 2, V::size() / 2>(v);
        return stdx::reduce(stdx::static_simd_cast<Half>(low) + stdx::static_simd_cast<Half>(high));
    }
}

#ifdef __AVX512VL__
namespace detail {

[[gnu::always_inline]] inline __m512d as_doubles(const stdx::native_simd<double>& v) {
    return static_cast<__m512d>(v);
}
[[gnu::always_inline]] inline __m512d as_doubles(const FloatV& v) {
    const auto all = static_cast<__m512>(v);
    const __m512d low = _mm512_cvtps_pd(_mm512_castps512_ps256(all));
    const __m512d high =
        _mm512_cvtps_pd(_mm256_castpd_ps(_mm512_extractf64x4_pd(_mm512_castps_pd(all), 1)));
    return _mm512_add_pd(low, high);
}

/// Lane k of the result: the sum of the lanes of the first + k-th value, added in the order of
/// lane_sum.
template <std::size_t First, class V, std::size_t N>
[[gnu::always_inline]] inline __m512d sums_of_eight(const std::array<V, N>& v) {
    const auto fours = [&](std::size_t a, std::size_t b)
        __attribute__((always_inline)) {  // a0+a4 ... b3+b7
        const __m512d x = as_doubles(v[First + a]), y = as_doubles(v[First + b]);
        return _mm512_add_pd(_mm512_shuffle_f64x2(x, y, 0x44), _mm512_shuffle_f64x2(x, y, 0xee));
    };
    const auto twos = [](const __m512d& ab, const __m512d& cd) {
        return _mm512_add_pd(_mm512_shuffle_f64x2(ab, cd, 0x88),
                             _mm512_shuffle_f64x2(ab, cd, 0xdd));
    };
    const __m512d even = twos(fours(0, 2), fours(4, 6)), odd = twos(fours(1, 3), fours(5, 7));
    return _mm512_add_pd(_mm512_unpacklo_pd(even, odd), _mm512_unpackhi_pd(even, odd));
}

}  // namespace detail
#endif

/// lane_sum of each of N values, to the last bit; eight at a time where the target can: half the
/// time.
template <class V, std::size_t N>
[[gnu::always_inline]] inline std::array<double, N> lane_sums(const std::array<V, N>& values) {
    std::array<double, N> out;
#ifdef __AVX512VL__
    if constexpr (sizeof(V) == 64 && N % 8 == 0) {
        for_constants<N / 8>([&](auto k) __attribute__((always_inline)) {
            constexpr std::size_t first = 8 * decltype(k)::value;
            _mm512_storeu_pd(&out[first], detail::sums_of_eight<first>(values));
        });
        return out;
    }
#endif
    for (std::size_t k = 0; k < N; ++k) out[k] = lane_sum(values[k]);
    return out;
}

}  // namespace slim
