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
constexpr std::size_t kStrips = 4;
static_assert(kPlaces % kStrips == 0);
constexpr std::size_t kPointsAtOnce = 64;
static_assert(kPointsAtOnce <= 64 && kPointsAtOnce % kLanes == 0);
constexpr float kNowhere = 9;     // over rho: beyond all that is near a foot
constexpr float kMargin = 1e-5f;  // over rho: above the rounding of floats

/// Places spread evenly over the disc of radius kTrim, coordinates over rho in the tangent plane,
/// padded by places without. A spiral (Vogel 1979): the rows of a grid would see an edge along the
/// axes better than others. Groups lie together: in strips along v, up one and down the next.
struct Places {
    std::array<float, kMostGroups * kLanes> u, v;

    Places() {
        std::array<std::array<float, 2>, kPlaces> places;
        for (std::size_t i = 0; i < kPlaces; ++i) {
            const double r = kTrim * std::sqrt((static_cast<double>(i) + 0.5) / kPlaces);
            const double angle = static_cast<double>(i) * 2 * std::numbers::pi * kGoldenRatio;
            places[i] = {static_cast<float>(r * std::cos(angle)),
                         static_cast<float>(r * std::sin(angle))};
        }
        std::sort(places.begin(), places.end());
        constexpr auto kOfStrip = static_cast<std::ptrdiff_t>(kPlaces / kStrips);
        for (auto strip = places.begin(); strip != places.end(); strip += kOfStrip) {
            const bool is_upwards = (strip - places.begin()) / kOfStrip % 2 == 0;
            std::sort(strip, strip + kOfStrip, [&](const auto& a, const auto& b) {
                return is_upwards ? a[1] < b[1] : a[1] > b[1];
            });
        }
        u.fill(2), v.fill(2);
        for (std::size_t i = 0; i < kPlaces; ++i) u[i] = places[i][0], v[i] = places[i][1];
    }
};

using Doubles = stdx::native_simd<double>;

FloatV lanes_of(const auto& a, std::size_t group) {
    return {&a[group * static_cast<std::size_t>(kLanes)], stdx::element_aligned};
}

/// Those whose feet on a surfel are within its core, and the nearest point to each,
/// by groups of lanes.
struct Feet {
    std::array<float, (kMostGroups + 1) * kLanes> u, v, x, y, z, sq, index;
    std::size_t n = 0;

    std::size_t n_groups() const { return (n + kLanes - 1) / kLanes; }
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
        out.x[i] = out.x[out.n - 1], out.y[i] = out.y[out.n - 1], out.z[i] = out.z[out.n - 1];
}

/// What is no farther than a distance from the box of a group of feet.
struct FeetBox {
    std::array<float, 3> lo, hi;

    FeetBox() = default;
    FeetBox(const Feet& feet, std::size_t group, float reach) {
        const auto take = [&](std::size_t axis, const auto& a) {
            const FloatV x = lanes_of(a, group);
            lo[axis] = stdx::hmin(x) - reach, hi[axis] = stdx::hmax(x) + reach;
        };
        take(0, feet.x), take(1, feet.y), take(2, feet.z);
    }
};

/// A few points p of a ball: p, -2 p, |p|^2 and the index.
struct Points {
    template <class T>
    using Few = std::array<T, kPointsAtOnce>;
    Few<float> x, y, z, twice_x, twice_y, twice_z, sq, index;
    std::size_t n = 0;

    Points(const BallPoints<double>& ball, std::size_t first)
        : n(std::min(kPointsAtOnce, ball.n - first)) {
        for (std::size_t i = 0; i < n; ++i) {
            const std::size_t j = first + i;
            const Vec3d p{ball.x[j], ball.y[j], ball.z[j]};
            x[i] = static_cast<float>(p.x), y[i] = static_cast<float>(p.y),
            z[i] = static_cast<float>(p.z);
            twice_x[i] = -2 * x[i], twice_y[i] = -2 * y[i], twice_z[i] = -2 * z[i];
            sq[i] = static_cast<float>(sq_length(p)), index[i] = static_cast<float>(j);
        }
        for (std::size_t i = n; i % kLanes != 0; ++i) x[i] = y[i] = z[i] = kNowhere;
    }
    /// Bits of those in a box.
    std::uint64_t inside(const FeetBox& box) const {
        std::uint64_t bits = 0;
        for (std::size_t i = 0; i < n; i += kLanes) {
            const auto within = [&](const Few<float>& a, std::size_t axis) {
                const FloatV p(&a[i], stdx::element_aligned);
                return lane_bits(p >= box.lo[axis]) & lane_bits(p <= box.hi[axis]);
            };
            bits |= (within(x, 0) & within(y, 1) & within(z, 2)) << i;
        }
        return bits;
    }
};

/// Finds the nearest point p of each foot x by |p|^2 - 2 x . p, of those no farther than `reach`
/// from it, else any or none: a few points at a time over all feet, which stay in the cache.
[[gnu::flatten]] void find_nearest(const BallPoints<double>& ball, float reach, Feet& feet) {
    feet.sq.fill(4), feet.index.fill(0);  // no point of a ball is so far
    std::array<FeetBox, kMostGroups> boxes;
    for (std::size_t g = 0; g < feet.n_groups(); ++g) boxes[g] = FeetBox(feet, g, reach);
    for (std::size_t first = 0; first < ball.n; first += kPointsAtOnce) {
        const Points points(ball, first);
        for (std::size_t g = 0; g < feet.n_groups(); ++g) {
            const FloatV x = lanes_of(feet.x, g), y = lanes_of(feet.y, g), z = lanes_of(feet.z, g);
            FloatV least = lanes_of(feet.sq, g), index = lanes_of(feet.index, g);
            for (std::uint64_t bits = points.inside(boxes[g]); bits != 0; bits &= bits - 1) {
                const auto i = static_cast<std::size_t>(std::countr_zero(bits));
                const FloatV sq = lanes_fma(
                    x, FloatV(points.twice_x[i]),
                    lanes_fma(y, FloatV(points.twice_y[i]),
                              lanes_fma(z, FloatV(points.twice_z[i]), FloatV(points.sq[i]))));
                index = select(sq < least, FloatV(points.index[i]), index);
                least = stdx::min(sq, least);
            }
            least.copy_to(&feet.sq[g * kLanes], stdx::element_aligned);
            index.copy_to(&feet.index[g * kLanes], stdx::element_aligned);
        }
    }
}

}  // namespace

[[gnu::flatten]] std::vector<AirPlace> air_places(const Surfel& surfel,
                                                  const BallPoints<double>& ball) {
    std::vector<AirPlace> out;
    if (ball.n == 0) return out;
    const double spacing = std::sqrt(std::numbers::pi / static_cast<double>(ball.n));
    const double gap_sq = kGap * spacing * kGap * spacing;
    Feet feet;
    find_feet(surfel, feet);
    find_nearest(ball, static_cast<float>(kGap * spacing) + kMargin, feet);
    for (std::size_t first = 0; first < feet.n; first += Doubles::size()) {
        const auto of_nearest = [&](const auto* a) {
            return Doubles([&](auto lane) {
                return static_cast<double>(a[static_cast<std::size_t>(feet.index[first + lane])]);
            });
        };
        const auto foot = [&](const auto& a) {
            return stdx::static_simd_cast<Doubles>(
                LanesOfDouble<float>(&a[first], stdx::element_aligned));
        };
        const Vec3<Doubles> normal{of_nearest(ball.nx.data()), of_nearest(ball.ny.data()),
                                   of_nearest(ball.nz.data())};
        const Vec3<Doubles> away{foot(feet.x) - of_nearest(ball.x.data()),
                                 foot(feet.y) - of_nearest(ball.y.data()),
                                 foot(feet.z) - of_nearest(ball.z.data())};
        const Doubles height = dot(normal, away);
        const std::uint64_t here = feet.n - first < Doubles::size()
                                       ? (std::uint64_t{1} << (feet.n - first)) - 1
                                       : ~std::uint64_t{0};
        const std::uint64_t far =
            lane_bits(dot(away, away) > gap_sq) | lane_bits(stdx::abs(height) > kFar * spacing);
        const std::uint64_t bits = (far | lane_bits(height > kStandsOut * spacing)) & here;
        for (std::uint64_t rest = bits; rest != 0; rest &= rest - 1) {
            const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
            out.push_back({feet.u[first + lane], feet.v[first + lane], (far >> lane & 1) != 0});
        }
    }
    return out;
}

}  // namespace slim
