#pragma once

#include "slim/base/simd.h"

#include <cmath>

namespace slim {

/// The Gaussian-like weight G of Ohtake 2005 sec. 2 as a function of the *squared* relative
/// distance s = (r / rho)^2:  exp(-8 s) for s <= 1/4, (16 / e^2) (1 - sqrt s)^4 up to 1, zero
/// beyond; C^2 (NUMERICS 2.3). One body for float, double and SIMD lanes. exp on [0, 2] is a
/// polynomial of degree 8, absolute error 5e-9.
template <class T>
[[gnu::always_inline]] inline T weight_kernel(const T& s) {
    using std::sqrt;
    const T t = s * constant<T>(8);
    T e = constant<T>(9.354704060759648e-06);
    e = e * t + constant<T>(-0.00015014194153847185);
    e = e * t + constant<T>(0.001299831894595563);
    e = e * t + constant<T>(-0.008233794333178368);
    e = e * t + constant<T>(0.04159999027555451);
    e = e * t + constant<T>(-0.1666412760246468);
    e = e * t + constant<T>(0.4999951173524763);
    e = e * t + constant<T>(-0.9999996362714046);
    e = e * t + constant<T>(0.9999999955155234);
    const T one_minus_x = constant<T>(1) - sqrt(s);
    const T sq = one_minus_x * one_minus_x;
    const T tail = constant<T>(2.16536453178580) * sq * sq;
    return select(s <= constant<T>(0.25), e, select(s < constant<T>(1), tail, constant<T>(0)));
}

/// What a fit weighs its points with (NUMERICS 2.3); the renderers blend with the first, refits for
/// smoothing take the last.
enum class FitWeight : unsigned char { gauss, polynomial, uniform };

/// The weight at a squared relative distance s = (r / rho)^2: weight_kernel, or (1 - s)^4 up to 1
/// and zero beyond, or 1 up to 1.
template <class T>
inline T fit_weight(FitWeight weight, const T& s) {
    if (weight == FitWeight::gauss) return weight_kernel(s);
    if (weight == FitWeight::uniform)
        return select(s < constant<T>(1), constant<T>(1), constant<T>(0));
    const T rest = constant<T>(1) - s;
    const T sq = rest * rest;
    return select(s < constant<T>(1), sq * sq, constant<T>(0));
}

}  // namespace slim
