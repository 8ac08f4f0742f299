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

    FloatV lanes(const auto& a, std::size_t group) const { return {&a[group * static_cast<std::size_t>(kLanes)], stdx::element_aligned}; }
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

/// A few points p of a ball: -2 p, |p|^2 and the index.
struct Points {
    std::array<float, kPointsAtOnce> x, y, z, sq, index;
    std::size_t n = 0;

    Points(const BallPoints<double>& ball, std::size_t first) : n(std::min(kPointsAtOnce, ball.n - first)) {
        for (std::size_t i = 0; i < n; ++i) {
            const std::size_t j = first + i;
            const Vec3d p{ball.x[j], ball.y[j], ball.z[j]};
            x[i] = static_cast<float>(-2 * p.x), y[i] = static_cast<float>(-2 * p.y), z[i] = static_cast<float>(-2 * p.z);
            sq[i] = static_cast<float>(sq_length(p)), index[i] = static_cast<float>(j);
        }
    }
};

/// Finds the nearest point p of each foot x by |p|^2 - 2 x . p: a few points at a time over all feet, which stay in the
/// cache.
[[gnu::flatten]] void find_nearest(const BallPoints<double>& ball, Feet& feet) {
    feet.sq.fill(4), feet.index.fill(0);  // no point of a ball is so far
    for (std::size_t first = 0; first < ball.n; first += kPointsAtOnce) {
        const Points points(ball, first);
        for (std::size_t g = 0; g < feet.n_groups(); ++g) {
            const FloatV x = feet.lanes(feet.x, g), y = feet.lanes(feet.y, g), z = feet.lanes(feet.z, g);
            FloatV least = feet.lanes(feet.sq, g), index = feet.lanes(feet.index, g);
            for (std::size_t i = 0; i < points.n; ++i) {
                const FloatV sq =
                    lanes_fma(x, FloatV(points.x[i]),
                              lanes_fma(y, FloatV(points.y[i]), lanes_fma(z, FloatV(points.z[i]), FloatV(points.sq[i]))));
                index = select(sq < least, FloatV(points.index[i]), index);
                least = stdx::min(sq, least);
            }
            least.copy_to(&feet.sq[g * kLanes], stdx::element_aligned);
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
        const Vec3d away = feet.foot(i) - Vec3d{ball.x[p], ball.y[p], ball.z[p]};
        const double height = dot(normal, away);
        const bool far = sq_length(away) > gap_sq || std::abs(height) > kFar * spacing;
        if (far || height > kStandsOut * spacing) out.push_back({feet.u[i], feet.v[i], far});
    }
    return out;
}

}  // namespace slim
