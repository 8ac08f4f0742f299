#pragma once

#include "slim/base/simd.h"

#include <type_traits>

namespace slim {

/// a b - c, rounded once; beside lanes_fma because g++ 12 makes an instruction of its own of a sign that two products share.
template <class V>
[[gnu::always_inline]] inline V lanes_fms(const V& a, const V& b, const V& c) {
#ifdef __AVX512VL__
    if constexpr (std::is_same_v<V, stdx::native_simd<float>> && sizeof(V) == 64)
        return V(_mm512_fmsub_ps(static_cast<__m512>(a), static_cast<__m512>(b), static_cast<__m512>(c)));
    else
#endif
        return stdx::fma(a, b, -c);
}

/// c - a b, rounded once.
template <class V>
[[gnu::always_inline]] inline V lanes_fnma(const V& a, const V& b, const V& c) {
#ifdef __AVX512VL__
    if constexpr (std::is_same_v<V, stdx::native_simd<float>> && sizeof(V) == 64)
        return V(_mm512_fnmadd_ps(static_cast<__m512>(a), static_cast<__m512>(b), static_cast<__m512>(c)));
    else
#endif
        return stdx::fma(-a, b, c);
}

}  // namespace slim
