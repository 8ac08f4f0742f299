#pragma once

#include "slim/base/hash.h"
#include "slim/model/surfel.h"

#include <cmath>
#include <cstdint>
#include <numbers>

namespace slim::test {

inline Vec3d random_unit(std::uint64_t seed) {
    const double z = 2 * unit_interval(keyed_hash(seed, 1)) - 1;
    const double angle = 2 * std::numbers::pi * unit_interval(keyed_hash(seed, 2));
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
}

/// A surfel on the unit sphere: osculating paraboloid w = -rho (u^2 + v^2) / 2.
inline Surfel sphere_surfel(const Vec3d& n, double rho) {
    Surfel s{n, rho, frame_from_normal(n), {}, 2};
    s.polynomial.a[3] = s.polynomial.a[5] = -rho / 2;
    return s;
}

inline Surfel random_cubic(std::uint64_t seed) {
    Surfel s{random_unit(seed), 0.5, frame_from_normal(random_unit(seed + 77)), {}, 3};
    for (std::size_t i = 0; i < 10; ++i)
        s.polynomial.a[i] = 0.2 * (2 * unit_interval(keyed_hash(seed, 10 + i)) - 1);
    return s;
}

}  // namespace slim::test
