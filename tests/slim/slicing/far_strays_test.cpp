#include "slim/slicing/far_strays.h"

#include "slim/base/hash.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace slim::test {
namespace {

/// n points of the unit box, and the strays.
FarStrays of_box(std::uint64_t n, const std::vector<Vec3d>& strays) {
    FarStrays all;
    for (std::uint64_t i = 0; i < n; ++i)
        all.add({unit_interval(keyed_hash(1, i)), unit_interval(keyed_hash(2, i)),
                 unit_interval(keyed_hash(3, i))});
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

}  // namespace
}  // namespace slim::test
