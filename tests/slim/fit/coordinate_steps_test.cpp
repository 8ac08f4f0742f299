#include "slim/fit/coordinate_steps.h"

#include "tests/slim/fit/noise_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace slim::test {
namespace {

CoordinateSteps steps_of(const std::vector<Vec3d>& points) {
    const PointBlock block = without_normals(points);
    std::vector<std::uint32_t> samples = samples_of(block);
    samples.resize(std::min(samples.size(), kStepSamples));
    return coordinate_steps(NearestSearch(block.position), samples);
}

double rounded(double x, double step) { return std::round(x / step) * step; }

/// A hilly raster of n x n heights, one apart.
std::vector<Vec3d> raster(int n, double step) {
    std::vector<Vec3d> points;
    for (int x = 0; x < n; ++x)
        for (int y = 0; y < n; ++y) {
            const double z = 8 * std::sin(x / 80.0) * std::cos(y / 60.0);
            points.push_back({1.0 * x, 1.0 * y, step > 0 ? rounded(z, step) : z});
        }
    return points;
}

/// Points of the surface of a cube of 2 n on a side at whole coordinates.
std::vector<Vec3d> cube_on_grid(int n) {
    std::vector<Vec3d> points;
    for (int x = -n; x <= n; ++x)
        for (int y = -n; y <= n; ++y)
            for (int z = -n; z <= n; ++z)
                if (std::max({std::abs(x), std::abs(y), std::abs(z)}) == n)
                    points.push_back({1.0 * x, 1.0 * y, 1.0 * z});
    return points;
}

TEST(CoordinateSteps, OfHeightsRoundedToWholeMetresAreATwelfth) {
    const CoordinateSteps steps = steps_of(raster(300, 1));
    EXPECT_GT(steps.n_stepped, steps.n_sampled / 8);
    EXPECT_GT(steps.n_rounded, steps.n_stepped * 9 / 10);
    // Slopes are 0.1 at the most: nearly all of a step is along the normal. A step that a
    // neighbourhood has a part of counts as whole.
    EXPECT_NEAR(steps.step_variance() * 12, 1, 0.05);
    EXPECT_NEAR(steps.noise_variance() * 12, 1.05, 0.1);
    EXPECT_NEAR(steps.noise_variance({0, 0.6, 0.8}) * 12, 0.64, 0.03);
    EXPECT_EQ(steps.noise_variance({1, 0, 0}), 0);
}

TEST(CoordinateSteps, AreSeenInFloatsFarFromTheOrigin) {
    std::vector<Vec3d> points = raster(300, 0.125);
    for (Vec3d& p : points) p.z = static_cast<float>(1e4 / 3 + p.z);
    EXPECT_NEAR(steps_of(points).noise_variance() * 12 * 64, 1, 0.05);
}

TEST(CoordinateSteps, NeedNotBeEqual) {
    // A depth is one over a whole disparity: steps of 0.7 to 1.3.
    std::vector<Vec3d> points = raster(300, 0);
    for (Vec3d& p : points) p.z = 1000 / rounded(1000 / (31.6 + p.z), 1);
    EXPECT_NEAR(steps_of(points).noise_variance() * 12, 1, 0.35);
}

TEST(CoordinateSteps, NoiseThatIsRoundedIsToldWithThem) {
    std::vector<Vec3d> points = raster(300, 0);
    std::uint64_t i = 0;
    for (Vec3d& p : points) p.z = rounded(p.z + 0.33 * gaussian(5, i++), 1);
    const CoordinateSteps steps = steps_of(points);
    EXPECT_NEAR(steps.step_variance() * 12, 1, 0.05);
    EXPECT_NEAR(steps.noise_variance(), 0.33 * 0.33 + 1 / 12.0, 0.02);
}

TEST(CoordinateSteps, OfAllThreeCoordinatesThoseAlongTheNormalCount) {
    std::vector<Vec3d> points = sampled("sphere", 100000).positions;
    for (Vec3d& p : points)
        for (double* x : {&p.x, &p.y, &p.z}) *x = rounded(*x, 0.01);
    const CoordinateSteps steps = steps_of(points);
    // n_a^2 of an axis below 1/4 is left out: of the whole sphere's sum of 1 an eighth.
    EXPECT_NEAR(steps.step_variance() * 12 / 1e-4, 0.88, 0.06);
    EXPECT_NEAR(steps.noise_variance() * 12 / 1e-4, 1.1, 0.12);
    EXPECT_NEAR(steps.noise_variance({0.6, 0, 0.8}) * 12 / 1e-4, 1, 0.05);
}

TEST(CoordinateSteps, OnGentleSlopesTheyAreSeenByFewerPoints) {
    // Terraces of 50 points, of which the nearest 640 see one or two.
    std::vector<Vec3d> points;
    for (int x = 0; x < 300; ++x)
        for (int y = 0; y < 300; ++y) points.push_back({1.0 * x, 1.0 * y, rounded(0.02 * x, 1)});
    EXPECT_NEAR(steps_of(points).noise_variance() * 12, 1, 0.05);
}

TEST(CoordinateSteps, ARasterOfExactHeightsHasNone) {
    const CoordinateSteps steps = steps_of(raster(300, 0));
    EXPECT_EQ(steps.n_stepped, 0u);
    EXPECT_EQ(steps.noise_variance(), 0);
}

TEST(CoordinateSteps, ExactSteepHillsOnARasterHaveNone) {
    // Where slopes are steep, the raster itself is along the normal, and a quadric over 640 points
    // misses as much of these hills as rounding would make.
    std::vector<Vec3d> points;
    for (int x = 0; x < 300; ++x)
        for (int y = 0; y < 300; ++y)
            points.push_back({1.0 * x, 1.0 * y, 20 * std::sin(x / 20.0) * std::cos(y / 20.0)});
    const CoordinateSteps steps = steps_of(points);
    EXPECT_GT(steps.n_stepped, 50u);
    EXPECT_EQ(steps.noise_variance(), 0);
}

TEST(CoordinateSteps, ExactSectionsHaveNone) {
    std::vector<Vec3d> points;
    for (int k = -49; k <= 49; ++k)
        for (int i = 0; i < 1500; ++i) {
            const double z = k / 50.0, angle = i * (2 * std::numbers::pi / 1500);
            const double bump = 0.1 * std::sin(5 * angle) * std::cos(6 * z);
            const double r = std::sqrt(1 - z * z) * (1 + bump);
            points.push_back({r * std::cos(angle), r * std::sin(angle), z});
        }
    const CoordinateSteps steps = steps_of(points);
    EXPECT_GT(steps.n_stepped, 30u);
    EXPECT_EQ(steps.noise_variance(), 0);
}

TEST(CoordinateSteps, ACubeOnAGridIsExactThoughItsEdgesHaveSteps) {
    const CoordinateSteps steps = steps_of(cube_on_grid(60));
    EXPECT_GT(steps.n_stepped, 50u);  // beside edges, where two faces are seen
    EXPECT_LT(steps.n_rounded, steps.n_stepped / 3);
    EXPECT_EQ(steps.noise_variance(), 0);
}

TEST(CoordinateSteps, AnExactSlopeOnAGridIsNoNoise) {
    std::vector<Vec3d> points;
    for (int x = 0; x < 200; ++x)
        for (int y = 0; y < 200; ++y) points.push_back({1.0 * x, 1.0 * y, 1.0 * (x + y)});
    const CoordinateSteps steps = steps_of(points);
    EXPECT_GT(steps.n_stepped, 200u);
    EXPECT_EQ(steps.n_rounded, 0u);
}

TEST(CoordinateSteps, WhereNoCoordinatesAreInCommonOnlyAFewNeighboursAreLookedAt) {
    EXPECT_EQ(steps_of(sampled("sphere", 20000).positions).n_stepped, 0u);
    EXPECT_EQ(steps_of(raster(20, 1)).n_stepped, 0u);  // fewer points than it takes
    EXPECT_EQ(steps_of({}).n_sampled, 0u);
}

TEST(CoordinateSteps, OfSlicesAddUp) {
    CoordinateSteps sum;
    sum += {100, 20, 18, 2.0, 3.0, {{{}, {}, {9, 24.0}}}};
    EXPECT_EQ(sum.step_variance(), 2.0);
    EXPECT_EQ(sum.noise_variance(), 3.0);
    sum += {50, 0, 0, 0, 0, {}};
    EXPECT_EQ(sum.step_variance(), 2.0);
    sum += {100, 10, 6, 6.0, 7.0, {{{}, {}, {3, 72.0}}}};
    EXPECT_EQ(sum.n_sampled, 250u);
    EXPECT_DOUBLE_EQ(sum.step_variance(), 3.0);
    EXPECT_DOUBLE_EQ(sum.noise_variance(), 4.0);
    EXPECT_DOUBLE_EQ(sum.noise_variance({0, 0, 1}), 3.0);
    sum += {100, 40, 0, 0, 0, {}};  // most of those that could say it do not
    EXPECT_EQ(sum.noise_variance(), 0);
    EXPECT_EQ(sum.noise_variance({0, 0, 1}), 0);
}

TEST(CoordinateSteps, FewPlacesDoNotTell) {
    EXPECT_EQ((CoordinateSteps{10000, 16, 16, 1.0, 1.0, {}}.noise_variance()), 0);  // a patch
    EXPECT_EQ((CoordinateSteps{200, 15, 15, 1.0, 1.0, {}}.noise_variance()), 0);
    EXPECT_EQ((CoordinateSteps{200, 16, 16, 1.0, 1.0, {}}.noise_variance()), 1);
}

}  // namespace
}  // namespace slim::test
