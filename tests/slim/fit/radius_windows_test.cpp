#include "slim/fit/radius_windows.h"

#include "tests/slim/fit/noise_support.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slim::test {
namespace {

struct Ground {
    PointBlock block;
    PointPyramid pyramid;
    double diagonal;
    MdlEnergy energy;

    Ground(PointBlock points, double mdl_threshold, double noise_variance)
        : block(std::move(points)),
          pyramid(block, box_of(block), 0),
          diagonal(box_of(block).diagonal()),
          energy{noise_variance, mdl_threshold * diagonal} {}

    RadiusWindows windows() const {
        return {pyramid, energy, diagonal / 10, diagonal * 1e-15, 2, LadderRules{}};
    }
    RadiusChoice choose(std::size_t i, int first) const {
        LadderWork work;
        return windows().choose(block.position[i], to_double(block.normal[i]), first, work);
    }
};

TEST(RadiusWindows, Row11FindTheOptimumOfASphereFromAnyLevel) {
    PointBlock block = block_of(sampled("sphere", 100000));
    const double lambda = measured_noise(block.position, 0, 10000).value;
    const Ground g(std::move(block), 0.005, lambda);
    const double optimum =  // NUMERICS 3.2, R = 1
        std::pow(16 * lambda * std::pow(0.005 * g.diagonal, 2) / 4.1003e-4, 0.1);
    // rho* = 0.54 rho_0: between m and r of window 0. Windows below must slide up to it.
    for (const int first : {0, 1, 3}) {
        SCOPED_TRACE(first);
        std::vector<double> radii;
        for (std::size_t i = 0; i < 99; ++i) {
            const RadiusChoice choice = g.choose(i * 1000, first);
            ASSERT_FALSE(choice.forced);
            radii.push_back(choice.radius);
        }
        std::nth_element(radii.begin(), radii.begin() + 49, radii.end());
        EXPECT_NEAR(radii[49] / optimum, 1, 0.05);
    }
}

TEST(RadiusWindows, SaturateOnAPlane) {
    const Ground g(graph_points(20000, 1, 1, [](double, double) { return 0.0; }), 0.01, 1e-20);
    for (const int first : {0, 2}) {
        const RadiusChoice choice = g.choose(7, first);
        EXPECT_TRUE(choice.saturated);
        EXPECT_FALSE(choice.forced);
        EXPECT_EQ(choice.radius, g.diagonal / 10);
    }
}

TEST(RadiusWindows, FinestIsTheSmallestRungWithPointsWhereverTheLeafIs) {
    const Ground g(graph_points(20000, 1, 1, [](double, double) { return 0.0; }), 0.01, 1e-20);
    for (const std::size_t i : {7, 400, 9000}) {
        const RadiusChoice choice = g.choose(i, 0);
        ASSERT_TRUE(choice.saturated);
        const auto holds = [&](double radius) {
            return count_in_ball(g.pyramid.all(), g.block.position[i], radius, 12) == 12;
        };
        EXPECT_TRUE(holds(choice.finest));
        EXPECT_FALSE(holds(choice.finest * kGoldenRatio));
        EXPECT_LT(choice.finest, choice.radius / 2);
    }
}

TEST(RadiusWindows, EndForcedWhereTooFewPointsAreLeft) {
    // White noise of height: E has no minimum that its errors agree with, but where points run out.
    std::uint64_t i = 0;
    const Ground g(graph_points(2000, 1, 1, [&](double, double) { return 0.3 * gaussian(3, i++); }),
                   1e-6, 1e-8);
    std::size_t forced = 0;
    for (std::size_t k = 0; k < 100; ++k) forced += g.choose(k, 0).forced;
    EXPECT_GT(forced, 50u);
}

}  // namespace
}  // namespace slim::test
