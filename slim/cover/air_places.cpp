#include "slim/cover/air_places.h"

#include "slim/base/simd.h"

#include <cmath>
#include <cstddef>
#include <numbers>

namespace slim {
namespace {

constexpr int kGrid = 8;             // places to either side of the centre
constexpr double kGap = 1.5;         // spacings to the nearest point: among random ones once in a thousand places
constexpr double kStandsOut = 0.15;  // spacings above its plane, from which on a rim should end the leaf
constexpr double kFar = 0.3;         // spacings above or below it that a larger ball must not bring
constexpr double kFarthest = 2;      // over rho: nothing in a ball is

using Lanes = stdx::native_simd<double>;

Lanes lanes_at(const std::vector<double>& a, std::size_t i) {
    return {&a[i], stdx::element_aligned};
}

struct Nearest {
    std::size_t index = 0;
    double sq = kFarthest * kFarthest;
};

Nearest nearest_to(const Vec3d& x, const BallPoints<double>& ball) {
    Lanes sq = Nearest{}.sq, index = 0;
    for (std::size_t first = 0; first < ball.n; first += Lanes::size()) {
        const Lanes dx = lanes_at(ball.x, first) - x.x, dy = lanes_at(ball.y, first) - x.y,
                    dz = lanes_at(ball.z, first) - x.z;
        const Lanes here([&](auto lane) { return static_cast<double>(first + lane); });
        const Lanes away = dx * dx + dy * dy + dz * dz;
        const auto nearer = here < static_cast<double>(ball.n) && away < sq;
        index = select(nearer, here, index);
        sq = select(nearer, away, sq);
    }
    Nearest out;
    for (std::size_t lane = 0; lane < Lanes::size(); ++lane)
        if (sq[lane] < out.sq) out = {static_cast<std::size_t>(index[lane]), sq[lane]};
    return out;
}

}  // namespace

std::vector<AirPlace> air_places(const Surfel& surfel, const BallPoints<double>& ball) {
    std::vector<AirPlace> out;
    if (ball.n == 0) return out;
    const double spacing = std::sqrt(std::numbers::pi / static_cast<double>(ball.n));
    for (int i = -kGrid; i <= kGrid; ++i)
        for (int j = -kGrid; j <= kGrid; ++j) {
            const double u = kTrim * i / kGrid, v = kTrim * j / kGrid;
            const Vec3d x = surfel.frame.world_from_local({u, v, surfel.polynomial.value(u, v)});
            if (sq_length(x) >= kTrim * kTrim) continue;
            const Nearest p = nearest_to(x, ball);
            const Vec3d normal{ball.nx[p.index], ball.ny[p.index], ball.nz[p.index]};
            const double height = dot(normal, x - Vec3d{ball.x[p.index], ball.y[p.index], ball.z[p.index]});
            const bool far = std::sqrt(p.sq) > kGap * spacing || std::abs(height) > kFar * spacing;
            if (far || height > kStandsOut * spacing)
                out.push_back({static_cast<float>(u), static_cast<float>(v), far});
        }
    return out;
}

}  // namespace slim
