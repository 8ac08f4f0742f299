#include "tests/pipeline/build/fit_stages_support.h"

#include <gtest/gtest.h>

namespace slim::test {
namespace {

using FarStraysStage = FitStages;

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

}  // namespace
}  // namespace slim::test
