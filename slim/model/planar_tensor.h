#pragma once

#include <array>
#include <cstddef>

namespace slim {

/// A symmetric tensor of order N over a plane: entry k is that of N - k times u and k times v.
template <std::size_t N>
using PlanarTensor = std::array<double, N + 1>;

/// How often entry k stands in a tensor of order N.
constexpr double n_times(std::size_t n, std::size_t k) {
    return k == 0 ? 1 : n_times(n, k - 1) * static_cast<double>(n - k + 1) / static_cast<double>(k);
}

/// With one of its places taken by (u, v).
template <std::size_t N>
PlanarTensor<N - 1> times(const PlanarTensor<N>& s, double u, double v) {
    static_assert(N >= 1);
    PlanarTensor<N - 1> out;
    for (std::size_t k = 0; k < N; ++k) out[k] = u * s[k] + v * s[k + 1];
    return out;
}

/// Other axes of a plane in its own: the new u is (u_u, u_v), the new v (v_u, v_v).
struct PlaneTurn {
    double u_u, u_v, v_u, v_v;
};

namespace planar_tensor_detail {

/// With n_v of its places taken by the new v, the others by the new u.
template <std::size_t N>
double entry(const PlanarTensor<N>& s, const PlaneTurn& turn, std::size_t n_v) {
    if constexpr (N == 0) return s[0];
    else if (n_v > 0) return entry<N - 1>(times<N>(s, turn.v_u, turn.v_v), turn, n_v - 1);
    else return entry<N - 1>(times<N>(s, turn.u_u, turn.u_v), turn, 0);
}

}  // namespace planar_tensor_detail

/// The same tensor in new axes.
template <std::size_t N>
PlanarTensor<N> turned(const PlanarTensor<N>& s, const PlaneTurn& turn) {
    PlanarTensor<N> out;
    for (std::size_t k = 0; k <= N; ++k) out[k] = planar_tensor_detail::entry<N>(s, turn, k);
    return out;
}

}  // namespace slim
