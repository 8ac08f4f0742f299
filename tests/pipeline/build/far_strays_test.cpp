#include "tests/pipeline/extremes_support.h"

#include <gtest/gtest.h>

namespace slim::test {
namespace {

using FarStraysStage = Extremes;

TEST_F(FarStraysStage, DoNotCountForTheCloudsSizeInOneSliceAndInSeveral) {
    Cloud cloud = sampled("sphere", 20000);
    slice(write(cloud, "clean.ply"), 1);
    const double diagonal = read_plan(file("work")).diagonal;
    cloud.positions[7] = {1000, 1000, 1000};
    for (const int n : {1, 4}) {
        SCOPED_TRACE(n);
        slice(write(cloud, "stray.ply"), n);
        const SlicePlan plan = read_plan(file("work"));
        EXPECT_NEAR(plan.diagonal, diagonal, 0.01 * diagonal);
        EXPECT_EQ(plan.n_points, 20000u);
        normals();
        EXPECT_EQ(fit()["dropped_isolated"], 1);
    }
}

TEST_F(FarStraysStage, DoNotCountForTheStepOfTheCoordinates) {
    // The floats of the stray are 0.06 apart, those of the sphere 6e-8.
    Cloud cloud = sampled("sphere", 20000);
    slice(write_floats("clean.ply", cloud), 1);
    const double step = read_plan(file("work")).coordinate_quantum;
    EXPECT_GT(step, 0);
    cloud.positions[7] = {1e6, 1e6, 0};
    for (const int n : {1, 4}) {
        SCOPED_TRACE(n);
        slice(write_floats("stray.ply", cloud), n);
        EXPECT_EQ(read_plan(file("work")).coordinate_quantum, step);
        EXPECT_FALSE(warned_of("finer detail"));
        normals();
        EXPECT_FALSE(fit()["noise_variance_floored"].get<bool>());
    }
    // A cloud that is there itself has such steps.
    for (Vec3d& p : cloud.positions) p = p * 10000.0 + Vec3d{1e6, 1e6, 0};
    slice(write_floats("far.ply", cloud), 1);
    EXPECT_EQ(read_plan(file("work")).coordinate_quantum, 0.0625);
}

}  // namespace
}  // namespace slim::test
