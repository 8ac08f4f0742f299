#include "pipeline/far_strays.h"

#include "slim/base/hash.h"
#include "tests/pipeline/fit_stages_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace slim::test {
namespace {

/// n points of the unit box, and the strays.
FarStrays of_box(std::uint64_t n, const std::vector<Vec3d>& strays) {
    FarStrays all;
    for (std::uint64_t i = 0; i < n; ++i)
        all.add({unit_interval(keyed_hash(1, i)), unit_interval(keyed_hash(2, i)), unit_interval(keyed_hash(3, i))});
    for (const Vec3d& p : strays) all.add(p);
    return all;
}

TEST(FarStrays, AreFewAndFarFromAllOthers) {
    for (const double far : {5.0, 100.0, 1e6}) {
        SCOPED_TRACE(far);
        const FarStrays::Found found = of_box(5000, {{far, far, 0.5}, {-far, 0.5, 0.5}}).find(5002);
        EXPECT_EQ(found.n, 2u);
        EXPECT_LT(found.box.diagonal(), std::sqrt(3.0));
        EXPECT_GT(found.box.diagonal(), 1.7);
    }
}

TEST(FarStrays, AreNoneWhereTheCloudIsNotMuchLargerOrTheyAreMany) {
    EXPECT_EQ(of_box(5000, {}).find(5000).n, 0u);
    EXPECT_EQ(of_box(5000, {{1.8, 0.5, 0.5}}).find(5001).n, 0u);   // less than twice as large
    EXPECT_EQ(of_box(500, {{100, 0.5, 0.5}}).find(501).n, 0u);     // one in 500
    std::vector<Vec3d> many;
    for (int i = 0; i < 9; ++i) many.push_back({50.0 + i, 0.5, 0.5});
    EXPECT_EQ(of_box(20000, many).find(20009).n, 0u);  // that may be a mast
    EXPECT_EQ(FarStrays().find(0).n, 0u);
}

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
