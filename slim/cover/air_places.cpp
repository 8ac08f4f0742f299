#include "slim/cover/air_places.h"

#include "slim/base/simd.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace slim {
namespace {

constexpr double kGap = 1.5;         // spacings to the nearest point: among
                                     // random ones once in a thousand places
constexpr double kStandsOut = 0.15;  // spacings above its plane, from which
                                     // on a rim should end the leaf
constexpr double kFar = 0.3;         // spacings above or below it that a larger ball must not bring

constexpr std::size_t kPlaces = 208;  // of a core
constexpr std::size_t kMostGroups = (kPlaces + kLanes - 1) / kLanes;
constexpr std::size_t kPointsAtOnce = 64;

/// Places spread evenly over the disc of radius kTrim, coordinates over rho in the tangent plane,
/// padded by places without. A spiral (Vogel 1979): the rows of a grid would see an edge along the
/// axes better than others.
struct Places {
    std::array<float, kMostGroups * kLanes> u, v;

    Places() {
        u.fill(2), v.fill(2);
        for (std::size_t i = 0; i < kPlaces; ++i) {
            const double r = kTrim * std::sqrt((static_cast<double>(i) + 0.5) / kPlaces);
            const double angle = static_cast<double>(i) * 2 * std::numbers::pi * kGoldenRatio;
            u[i] = static_cast<float>(r * std::cos(angle)),
            v[i] = static_cast<float>(r * std::sin(angle));
        }
    }
};

FloatV lanes_of(const auto& a, std::size_t group) {
    return {&a[group * static_cast<std::size_t>(kLanes)], stdx::element_aligned};
}

/// Those whose feet on a surfel are within its core, and the nearest point to each,
/// by groups of lanes.
struct Feet {
    std::array<float, (kMostGroups + 1) * kLanes> u, v, x, y, z, sq, index;
    std::size_t n = 0;

    std::size_t n_groups() const { return (n + kLanes - 1) / kLanes; }
    Vec3d foot(std::size_t i) const {
        return {static_cast<double>(x[i]), static_cast<double>(y[i]), static_cast<double>(z[i])};
    }
};

[[gnu::flatten]] void find_feet(const Surfel& surfel, Feet& out) {
    static const Places places;
    const auto spread = [](const Vec3d& a) {
        const Vec3f f = to_float(a);
        return Vec3<FloatV>{FloatV(f.x), FloatV(f.y), FloatV(f.z)};
    };
    const Frame<FloatV> frame{spread(surfel.frame.u_axis), spread(surfel.frame.v_axis),
                              spread(surfel.frame.normal)};
    Polynomial<FloatV> polynomial;
    for (std::size_t k = 0; k < polynomial.a.size(); ++k)
        polynomial.a[k] = static_cast<float>(surfel.polynomial.a[k]);
    for (std::size_t g = 0; g < kMostGroups; ++g) {
        const FloatV u = lanes_of(places.u, g), v = lanes_of(places.v, g);
        const Vec3<FloatV> p = frame.world_from_local({u, v, polynomial.value(u, v)});
        const std::uint64_t inside = lane_bits(dot(p, p) < static_cast<float>(kTrim * kTrim));
        const auto put = [&](const FloatV& from, auto& to) {
            compress_to(from, inside, &to[out.n]);
        };
        put(u, out.u), put(v, out.v), put(p.x, out.x), put(p.y, out.y), put(p.z, out.z);
        out.n += static_cast<std::size_t>(std::popcount(inside));
    }
    for (std::size_t i = out.n; i < out.n_groups() * kLanes; ++i)
        out.x[i] = out.y[i] = out.z[i] = 0;
}

/// A few points p of a ball: -2 p, |p|^2 and the index.
struct Points {
    std::array<float, kPointsAtOnce> x, y, z, sq, index;
    std::size_t n = 0;

    Points(const BallPoints<double>& ball, std::size_t first)
        : n(std::min(kPointsAtOnce, ball.n - first)) {
        for (std::size_t i = 0; i < n; ++i) {
            const std::size_t j = first + i;
            const Vec3d p{ball.x[j], ball.y[j], ball.z[j]};
            x[i] = static_cast<float>(-2 * p.x), y[i] = static_cast<float>(-2 * p.y),
            z[i] = static_cast<float>(-2 * p.z);
            sq[i] = static_cast<float>(sq_length(p)), index[i] = static_cast<float>(j);
        }
    }
};

/// Finds the nearest point p of each foot x by |p|^2 - 2 x . p: a few points at a time over all
/// feet, which stay in the cache.
[[gnu::flatten]] void find_nearest(const BallPoints<double>& ball, Feet& feet) {
    feet.sq.fill(4), feet.index.fill(0);  // no point of a ball is so far
    for (std::size_t first = 0; first < ball.n; first += kPointsAtOnce) {
        const Points points(ball, first);
        for (std::size_t g = 0; g < feet.n_groups(); ++g) {
            const FloatV x = lanes_of(feet.x, g), y = lanes_of(feet.y, g), z = lanes_of(feet.z, g);
            FloatV least = lanes_of(feet.sq, g), index = lanes_of(feet.index, g);
            for (std::size_t i = 0; i < points.n; ++i) {
                const FloatV sq =
                    lanes_fma(x, FloatV(points.x[i]),
                              lanes_fma(y, FloatV(points.y[i]),
                                        lanes_fma(z, FloatV(points.z[i]), FloatV(points.sq[i]))));
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
    Feet feet;
    find_feet(surfel, feet);
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
