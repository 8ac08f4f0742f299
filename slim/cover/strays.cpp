#include "slim/cover/strays.h"

#include "slim/model/surfel.h"
#include "slim/normals/covariance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <vector>

namespace slim {
namespace {

// Times the density of strays, which is their mean without those near a surface, and deviations.
constexpr double kDenser = 6, kByChance = 6;
constexpr double kFillsSpace = 0.135;  // thick: at an edge 0.085, at a corner of a cube 0.13
constexpr double kGrowsFast = 4.8;     // growth
constexpr double kOff = 0.1;           // off, of a centre above a surface that the ball reaches
constexpr double kFarOff = 0.32;       // off, however the points grow: on an edge it is 0.3

}  // namespace

BallShape shape_of(const BallPoints<double>& ball) {
    std::vector<Vec3d> positions(ball.n);
    Vec3d mean;
    std::size_t n_middle = 0;
    for (std::size_t i = 0; i < ball.n; ++i) {
        positions[i] = {ball.x[i], ball.y[i], ball.z[i]};
        mean = mean + positions[i] / static_cast<double>(ball.n);
        n_middle += ball.sq[i] < 0.25;
    }
    std::vector<std::uint32_t> all(ball.n);
    std::iota(all.begin(), all.end(), 0u);
    const Spread spread = spread_of(positions, all);
    const double sum = spread.smallest + spread.middle + spread.largest;
    return {static_cast<double>(ball.n) / static_cast<double>(std::max<std::size_t>(n_middle, 1)),
            sum > 0 ? spread.smallest / sum : 0, std::abs(dot(spread.normal, mean))};
}

bool stands_among_strays(const PointTree& points, const Vec3d& center, double radius,
                         double stray_density, BallPoints<double>& ball) {
    // A surface that reaches into the ball hardly reaches into the next smaller one, which holds
    // too few points for a leaf.
    const double inner = kGoldenRatio * radius;
    const double expected =
        stray_density * 4 / 3 * std::numbers::pi * inner * inner * inner;
    const double most = kDenser * expected + kByChance * std::sqrt(expected) + 3;
    const auto enough = static_cast<std::size_t>(most) + 1;
    if (count_in_ball(points, center, inner, enough) >= enough) return false;
    gather_ball(points, center, 2 * radius, ball);
    if (ball.n == 0) return false;
    const BallShape shape = shape_of(ball);
    return shape.thick > kFillsSpace || shape.off > kFarOff ||
           (shape.growth > kGrowsFast && shape.off > kOff);
}

}  // namespace slim
