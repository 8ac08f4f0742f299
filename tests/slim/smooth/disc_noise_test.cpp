#include "slim/smooth/disc_noise.h"

#include "slim/base/hash.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

namespace slim {
namespace {

double uniform(std::uint64_t i, std::uint64_t key) { return unit_interval(keyed_hash(7, i, key)); }

double gaussian(std::uint64_t i) {
    return std::sqrt(-2 * std::log(1 - uniform(i, 3))) * std::cos(2 * M_PI * uniform(i, 4));
}

/// Noise that is found over [-1, 1]^2, of the mean over some clouds of n points.
double found(const std::function<double(double, double)>& height, double noise, std::size_t n) {
    double mean = 0;
    constexpr int kClouds = 20;
    for (int c = 0; c < kClouds; ++c) {
        std::vector<double> u, v, h;
        for (std::size_t i = 0; i < n; ++i) {
            const std::uint64_t id = static_cast<std::uint64_t>(c) * 1000 + i;
            u.push_back(2 * uniform(id, 1) - 1), v.push_back(2 * uniform(id, 2) - 1);
            h.push_back(height(u.back(), v.back()) + noise * gaussian(id));
        }
        const auto sq = pseudo_residual_noise(u, v, h);
        EXPECT_TRUE(sq);
        mean += std::sqrt(sq.value_or(0)) / kClouds;
    }
    return mean;
}

TEST(PseudoResidualNoise, IsThatOfThePointsOnAnyPlane) {
    EXPECT_NEAR(found([](double u, double v) { return 3 + u - 2 * v; }, 0.01, 80), 0.01, 0.001);
    EXPECT_LT(found([](double u, double v) { return 3 + u - 2 * v; }, 0, 80), 1e-12);
}

TEST(PseudoResidualNoise, DoesNotTakeARoofForNoise) {
    // The residual of a plane through the roof would be 0.3.
    EXPECT_LT(found([](double u, double) { return std::abs(u); }, 0.01, 150), 0.016);
    EXPECT_LT(found([](double u, double) { return std::abs(u); }, 0, 150), 1e-12);
}

TEST(PseudoResidualNoise, OfScanLinesFarApartDoesNotFollowNoiseThatLeans) {
    // Heights and feet are off together, as along rays that are not quite upright in the frame: the
    // points of a line lie in a steep plane that holds their noise.
    double mean = 0;
    constexpr int kClouds = 20;
    for (std::uint64_t c = 0; c < kClouds; ++c) {
        std::vector<double> u, v, h;
        for (std::uint64_t i = 0; i < 150; ++i) {
            const double noise = 0.01 * gaussian(c * 1000 + i);
            u.push_back(2 * uniform(c * 1000 + i, 1) - 1),
                v.push_back(static_cast<double>(i % 3) - 1 + 0.1 * noise);
            h.push_back(0.2 * u.back() + noise);
        }
        mean += std::sqrt(pseudo_residual_noise(u, v, h).value_or(0)) / kClouds;
    }
    EXPECT_NEAR(mean, 0.01, 0.002);
}

TEST(PseudoResidualNoise, NeedsTwelvePoints) {
    const std::vector<double> few(11, 0.0);
    EXPECT_FALSE(pseudo_residual_noise(few, few, few));
    const std::vector<double> same(20, 0.0);  // no plane through one place
    EXPECT_FALSE(pseudo_residual_noise(same, same, same));
}

}  // namespace
}  // namespace slim
