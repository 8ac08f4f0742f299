#include "slim/fit/sharp_filled.h"

#include "slim/fit/double_lanes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slim {
namespace {

constexpr int kGrid = 5;             // places from the middle of a sheet to the rim of the core
constexpr double kLeastGap = 0.25;   // over rho: places on a sheet have a point as near as that,
constexpr double kGap = 2.5;         // or so many spacings,
constexpr double kFacing = 0.5;      // whose normal has at least this cosine to the sheet's
constexpr double kBeside = 1.2;      // spacings: whose planes a place must not stand out of,
constexpr double kStandsOut = 0.05;  // over rho, by more than that
constexpr double kNoises = 2.5;       // and so many standard deviations of the points

/// What places on the joined surface are held against; lengths over rho.
struct Limits {
    double sq_gap, sq_beside;
    double side;  ///< of the points' planes where the surface lies: 1 below, -1 above, 0 either
                  ///< (mixed corners)
    double stands_out;
};

template <class T>
Limits limits_of(const SharpFit& fit, const BallPoints<T>& points, double noise_variance) {
    const double spacing = std::sqrt(std::numbers::pi / static_cast<double>(points.n));
    const double gap = std::max(kLeastGap, kGap * spacing),
                 beside = std::min(kBeside * spacing, gap);
    const bool is_mixed = fit.n_sheets > 2 && fit.outer != fit.inner;
    return {gap * gap, beside * beside, is_mixed ? 0.0 : fit.outer == Join::max ? 1.0 : -1.0,
            kStandsOut + kNoises * std::sqrt(noise_variance) / points.radius};
}

/// Whether the points bear out a place x on a sheet of that normal. Padding has no normal: it says
/// nothing.
template <class T>
bool is_borne_out(const BallPoints<T>& points, const Vec3d& x, const Vec3d& normal,
                  const Limits& limits) {
    bool found = false;
    for (std::size_t i = 0; i < points.n; i += DoubleLanes::size()) {
        const Vec3<DoubleLanes> away{x.x - double_lanes_at(points.x, i),
                                     x.y - double_lanes_at(points.y, i),
                                     x.z - double_lanes_at(points.z, i)};
        const DoubleLanes sq = sq_length(away);
        const auto is_near = sq <= limits.sq_gap;
        if (lane_bits(is_near) == 0) continue;
        const Vec3<DoubleLanes> n{double_lanes_at(points.nx, i), double_lanes_at(points.ny, i),
                                  double_lanes_at(points.nz, i)};
        const auto stands_out =
            sq <= limits.sq_beside && limits.side * dot(n, away) > limits.stands_out;
        if (lane_bits(is_near && stands_out) != 0) return false;
        const Vec3<DoubleLanes> to{DoubleLanes(normal.x), DoubleLanes(normal.y),
                                   DoubleLanes(normal.z)};
        found = found || lane_bits(is_near && dot(n, to) > kFacing) != 0;
    }
    return found;
}

}  // namespace

template <class T>
bool is_filled(const SharpFit& fit, const BallPoints<T>& points, double noise_variance) {
    const Surfel s = fit.surfel({}, 1);
    const Limits limits = limits_of(fit, points, noise_variance);
    for (std::size_t k = 0; k < fit.n_sheets; ++k)
        for (int i = -kGrid; i <= kGrid; ++i)
            for (int j = -kGrid; j <= kGrid; ++j) {
                const double u = kTrim * i / kGrid, v = kTrim * j / kGrid;
                const Vec3d x =
                    fit.frame[k].world_from_local({u, v, fit.polynomial[k].value(u, v)});
                if (sq_length(x) >= kTrim * kTrim) continue;
                if (!s.sharp->on_surface(k, s.sheet_values(x))) continue;
                if (!is_borne_out(points, x, normalized(s.sheet_gradient(k, x)), limits))
                    return false;
            }
    return true;
}

template bool is_filled(const SharpFit&, const BallPoints<float>&, double);
template bool is_filled(const SharpFit&, const BallPoints<double>&, double);

}  // namespace slim
