#pragma once

#include "slim/base/simd.h"
#include "slim/model/polynomial.h"

#include <array>
#include <cstddef>

namespace slim {

/// The second derivatives P_uu, P_uv, P_vv of a height field all over its ball, each a polynomial
/// of degree 2 in its u and v (relative to the centre and over rho, as Polynomial): coefficients of
/// 1, u, v, u^2, uv, v^2. Those of a polynomial itself, or what its neighbours say of the surface
/// beyond it (slim/blend/leaf_hessians.h).
struct HeightHessian {
    std::array<std::array<float, 6>, 3> c{};

    /// P_uu, P_uv, P_vv. V: float, double, or lanes.
    template <class V>
    std::array<V, 3> at(const V& u, const V& v) const {
        const auto entry = [&](const std::array<float, 6>& a) {
            return constant<V>(a[0]) +
                   u * (constant<V>(a[1]) + u * constant<V>(a[3]) + v * constant<V>(a[4])) +
                   v * (constant<V>(a[2]) + v * constant<V>(a[5]));
        };
        return {entry(c[0]), entry(c[1]), entry(c[2])};
    }
};

/// That of a polynomial, exactly.
template <class T>
HeightHessian hessian_of(const Polynomial<T>& p) {
    const auto f = [&](double factor, std::size_t k) {
        return static_cast<float>(factor * static_cast<double>(p.a[k]));
    };
    return {{{{f(2, 3), f(6, 6), f(2, 7), 0, 0, 0},
              {f(1, 4), f(2, 7), f(2, 8), 0, 0, 0},
              {f(2, 5), f(2, 8), f(6, 9), 0, 0, 0}}}};
}

}  // namespace slim
