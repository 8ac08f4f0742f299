#include "pipeline/build/build_summary.h"
#include "tests/pipeline/extremes_support.h"
#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace slim::test {
namespace {

using SteppedClouds = Extremes;

/// Hills of 6 with slopes up to 0.3, four points a unit, heights rounded to whole units.
std::vector<Vec3d> hills_in_whole_units(int n) {
    std::vector<Vec3d> points;
    for (int x = 0; x < n; ++x)
        for (int y = 0; y < n; ++y)
            points.push_back({0.25 * x, 0.25 * y,
                              std::round(6 * std::sin(x / 80.0) * std::cos(y / 60.0))});
    return points;
}

TEST_F(SteppedClouds, StepsOfHeightsAreNoiseAndNoTerracesInAnyNumberOfSlices) {
    const std::string cloud = write_text("hills.xyz", hills_in_whole_units(250));
    for (const int slices : {1, 4}) {
        SCOPED_TRACE(slices);
        BuildConfig config = build_config(cloud, "m.slim");
        config.slices = slices;
        const auto result = build(config);
        EXPECT_NEAR(fit_of(result)["step_variance"].get<double>() * 12, 0.93, 0.05);
        EXPECT_NEAR(result["noise_variance"].get<double>() * 12, 1, 0.2);
        EXPECT_LT(result["leaves"].get<int>(), 200);  // of terraces 3,542
        const std::string told = build_summary(config.output, config.inputs, result);
        EXPECT_NE(told.find("(of coordinates in steps)"), std::string::npos) << told;
    }
}

TEST_F(SteppedClouds, NoiseOfAStepIsLambdaAndTheStepsTheLeastOfABall) {
    std::vector<Vec3d> points = hills_in_whole_units(250);
    std::uint64_t i = 0;
    for (Vec3d& p : points) p.z = std::round(p.z + 0.7 * gaussian(4, i++));
    const auto result = build(build_config(write_text("noisy.xyz", points), "m.slim"));
    EXPECT_GT(result["noise_variance"].get<double>(), 0.3);  // of 0.57
    EXPECT_NEAR(fit_of(result)["step_variance"].get<double>() * 12, 0.93, 0.1);
    const std::string told = build_summary(file("m.slim"), {file("noisy.xyz")}, result);
    EXPECT_EQ(told.find("in steps"), std::string::npos) << told;
}

TEST_F(SteppedClouds, LambdaThatIsGivenAndThickNoiseKnowNoSteps) {
    std::vector<Vec3d> points = hills_in_whole_units(100);
    BuildConfig config = build_config(write_text("hills.xyz", points), "m.slim");
    config.lambda = 0.01;
    auto result = build(config);
    EXPECT_EQ(result["noise_variance"], 0.01);
    EXPECT_EQ(fit_of(result)["step_variance"], 0);
    std::uint64_t i = 0;
    for (Vec3d& p : points) p.z = std::round(p.z + 3 * gaussian(4, i++));
    result = build(build_config(write_text("noisy.xyz", points), "m.slim"));
    EXPECT_NEAR(result["noise_variance"].get<double>(), 9, 3);
    EXPECT_EQ(fit_of(result)["step_variance"], 0);
    const std::string told = build_summary(file("m.slim"), {file("noisy.xyz")}, result);
    EXPECT_EQ(told.find("in steps"), std::string::npos) << told;
}

}  // namespace
}  // namespace slim::test
