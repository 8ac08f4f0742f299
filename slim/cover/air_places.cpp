#include "slim/cover/air_places.h"

#include "slim/base/simd.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace slim {
namespace {

constexpr int kGrid = 8;             // places to either side of the centre
constexpr double kGap = 1.5;         // spacings to the nearest point: among random ones once in a thousand places
constexpr double kStandsOut = 0.15;  // spacings above its plane, from which on a rim should end the leaf
constexpr double kFar = 0.3;         // spacings above or below it that a larger ball must not bring

constexpr std::size_t kSide = 2 * kGrid + 1;
constexpr std::size_t kMostGroups = (kSide * kSide + kLanes - 1) / kLanes;
constexpr std::size_t kPointsAtOnce = 64;

/// Places of the grid within the core, their feet on a surfel, and the nearest point to each, by groups of lanes.
struct Feet {
    std::array<float, kMostGroups * kLanes> u{}, v{}, x, y, z, sq, index;
    std::size_t n = 0;

    FloatV lanes(const auto& a, std::size_t group) const { return {&a[group * kLanes], stdx::element_aligned}; }
    std::size_t n_groups() const { return (n + kLanes - 1) / kLanes; }
    Vec3d foot(std::size_t i) const {
        return {static_cast<double>(x[i]), static_cast<double>(y[i]), static_cast<double>(z[i])};
    }
};

Feet feet_on(const Surfel& surfel) {
    Feet out;
    for (int i = -kGrid; i <= kGrid; ++i)
        for (int j = -kGrid; j <= kGrid; ++j) {
            const double u = kTrim * i / kGrid, v = kTrim * j / kGrid;
            const Vec3d p = surfel.frame.world_from_local({u, v, surfel.polynomial.value(u, v)});
            if (sq_length(p) >= kTrim * kTrim) continue;
            out.u[out.n] = static_cast<float>(u), out.v[out.n] = static_cast<float>(v);
            out.x[out.n] = static_cast<float>(p.x), out.y[out.n] = static_cast<float>(p.y);
            out.z[out.n++] = static_cast<float>(p.z);
        }
    for (std::size_t i = out.n; i < out.n_groups() * kLanes; ++i) out.x[i] = out.y[i] = out.z[i] = 0;
    return out;
}

/// Finds the nearest point of each foot: a few points at a time over all feet, which stay in the cache.
[[gnu::flatten]] void find_nearest(const BallPoints<double>& ball, Feet& feet) {
    feet.sq.fill(4), feet.index.fill(0);  // (2 rho)^2: nothing in a ball is farther
    std::array<float, kPointsAtOnce> x, y, z;
    for (std::size_t first = 0; first < ball.n; first += kPointsAtOnce) {
        const std::size_t n = std::min(kPointsAtOnce, ball.n - first);
        for (std::size_t i = 0; i < n; ++i) {
            x[i] = static_cast<float>(ball.x[first + i]), y[i] = static_cast<float>(ball.y[first + i]);
            z[i] = static_cast<float>(ball.z[first + i]);
        }
        for (std::size_t g = 0; g < feet.n_groups(); ++g) {
            const FloatV at_x = feet.lanes(feet.x, g), at_y = feet.lanes(feet.y, g), at_z = feet.lanes(feet.z, g);
            FloatV sq = feet.lanes(feet.sq, g), index = feet.lanes(feet.index, g);
            for (std::size_t i = 0; i < n; ++i) {
                const FloatV dx = at_x - x[i], dy = at_y - y[i], dz = at_z - z[i];
                const FloatV away = lanes_fma(dx, dx, lanes_fma(dy, dy, dz * dz));
                index = select(away < sq, FloatV(static_cast<float>(first + i)), index);
                sq = stdx::min(away, sq);
            }
            sq.copy_to(&feet.sq[g * kLanes], stdx::element_aligned);
            index.copy_to(&feet.index[g * kLanes], stdx::element_aligned);
        }
    }
}

}  // namespace

std::vector<AirPlace> air_places(const Surfel& surfel, const BallPoints<double>& ball) {
    std::vector<AirPlace> out;
    if (ball.n == 0) return out;
    const double spacing = std::sqrt(std::numbers::pi / static_cast<double>(ball.n));
    const double gap_sq = kGap * spacing * kGap * spacing;
    Feet feet = feet_on(surfel);
    find_nearest(ball, feet);
    for (std::size_t i = 0; i < feet.n; ++i) {
        const auto p = static_cast<std::size_t>(feet.index[i]);
        const Vec3d normal{ball.nx[p], ball.ny[p], ball.nz[p]};
        const double height = dot(normal, feet.foot(i) - Vec3d{ball.x[p], ball.y[p], ball.z[p]});
        const bool far = static_cast<double>(feet.sq[i]) > gap_sq || std::abs(height) > kFar * spacing;
        if (far || height > kStandsOut * spacing) out.push_back({feet.u[i], feet.v[i], far});
    }
    return out;
}

}  // namespace slim
