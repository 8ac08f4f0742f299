#include "slim/model/rim.h"

#include "slim/model/surfel_encoder.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slim {
namespace {

TEST(Rim, NoneIsTheWholeDisc) {
    EXPECT_TRUE(unpack_rim(0).is_whole());
    EXPECT_EQ(rim_share(unpack_rim(0), 1, 0), 1);
}

TEST(Rim, PackedItReachesAtLeastAsFar) {
    for (int k = 0; k < kRimDirections; ++k)
        for (const double reach : {0.0, 0.05, 0.08, 0.3, 0.55}) {
            const Rim rim = unpack_rim(pack_rim(k, reach));
            EXPECT_GE(rim.reach, reach);
            EXPECT_LE(rim.reach, std::max(reach, 0.001) + kRimStep);
            EXPECT_NEAR(std::hypot(rim.u, rim.v), 1, 1e-15);
            EXPECT_NEAR(rim_share(rim, rim.u * rim.reach, rim.v * rim.reach), 0, 1e-14);
            EXPECT_EQ(rim_share(rim, -rim.u, -rim.v), 1);
        }
    EXPECT_EQ(pack_rim(3, 0.57), 0);
}

TEST(Rim, OfALinearSurfelTurnsWithItsFrame) {
    Surfel s{{0, 0, 0}, 1, frame_from_normal(Vec3d{0, 0, 1}), {}, 1};
    s.polynomial.a[1] = 0.6, s.polynomial.a[2] = -0.3;
    for (int k = 0; k < kRimDirections; ++k) {
        s.rims.first = pack_rim(k, 0.3);
        const Surfel level = level_linear(s);
        const Rim before = unpack_rim(s.rims.first), after = unpack_rim(level.rims.first);
        const Vec3d out = s.frame.u_axis * before.u + s.frame.v_axis * before.v;
        const Vec3d turned = level.frame.u_axis * after.u + level.frame.v_axis * after.v;
        EXPECT_GT(dot(out, turned), 0.75) << k;  // a slope of 0.67 tilts it by up to 34 degrees
        EXPECT_GE(after.reach, before.reach);
    }
}

TEST(Rim, TheSecondComesFirstIfTheFirstReachesTooFarOnceTurned) {
    Surfel s{{0, 0, 0}, 1, frame_from_normal(Vec3d{0, 0, 1}), {}, 1};
    s.polynomial.a[1] = 0.6;
    s.rims = {pack_rim(0, 0.56), pack_rim(16, 0.1)};
    const PackedRims turned = level_linear(s).rims;
    EXPECT_TRUE(turned.any());
    EXPECT_EQ(turned.second, 0);
    EXPECT_LE(unpack_rim(turned.first).reach, 0.1 + 2.01 * kRimStep);
}

TEST(Rim, TwoLeaveASlab) {
    const PackedRims rims{pack_rim(0, 0.16), pack_rim(16, 0.32)};
    EXPECT_EQ(rim_share(rims, 0, 0.9), 1);
    EXPECT_NEAR(rim_share(rims, 0.11, 0), 0.5, 1e-9);
    EXPECT_EQ(rim_share(rims, 0.17, 0), 0);
    EXPECT_EQ(rim_share(rims, -0.2, 0), 1);
    EXPECT_EQ(rim_share(rims, -0.33, 0), 0);
}

TEST(Rim, ANodeHoldsAnyTwoBesideLevelAndDegree) {
    for (int first = 1; first < 256; ++first)
        for (int second = 0; second < 256; ++second) {
            TreeNode node;
            node.level = 63, node.degree = 3, node.flags = 255;
            const PackedRims rims{static_cast<PackedRim>(first), static_cast<PackedRim>(second)};
            node.set_rims(rims);
            ASSERT_EQ(node.rims(), rims);
            ASSERT_EQ(int{node.level}, 63);
            ASSERT_EQ(int{node.degree}, 3);
        }
}

}  // namespace
}  // namespace slim
