#include "slim/tree/drawn_beyond.h"

#include "slim/tree/drawn_bounds.h"
#include "tests/raytrace/support/analytic_models.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace slim {
namespace {

/// A flat disc across z.
Surfel disc(const Vec3d& center, double radius) {
    return {center, radius, frame_from_normal(Vec3d{0, 0, 1}), {}, 2};
}

BeyondBox beyond_of(const SurfelTreeData& data) {
    return drawn_beyond(data.view(), false, drawn_bounds(data.view(), false));
}

TEST(DrawnBeyond, IsTheDiscsOfAFewPoints) {
    SurfelTreeData data = test::flat_tree({disc({0, 0, 0}, 1), disc({1, 0, 0}, 1)}, 2);
    data.header.bounds = {{-0.1, -0.1, 0}, {1.1, 0.1, 0}};  // of the points
    set_drawn_bounds(data);
    const BeyondBox beyond = beyond_of(data);
    EXPECT_NEAR(beyond.box.lo.x, -kHitTrim, 1e-6);
    EXPECT_NEAR(beyond.box.hi.x, 1 + kHitTrim, 1e-6);
    EXPECT_NEAR(beyond.box.lo.y, -kHitTrim, 1e-3);
    EXPECT_NEAR(beyond.box.hi.y, kHitTrim, 1e-3);
    EXPECT_EQ(beyond.box.hi.z, 0);
    EXPECT_EQ(beyond.places.size(), 2 * 384u);
}

TEST(DrawnBeyond, IsNothingWhereDiscsEndAtThePoints) {
    SurfelTreeData data = test::sphere_model(1, 600);
    data.header.bounds = {{-1, -1, -1}, {1, 1, 1}};
    set_drawn_bounds(data);
    const BeyondBox beyond = beyond_of(data);
    EXPECT_TRUE(beyond.places.empty());
    EXPECT_EQ(beyond.box.lo, data.header.drawn.lo);
    EXPECT_EQ(beyond.box.hi, data.header.drawn.hi);
}

TEST(DrawnBeyond, ASideThatOneDiscCrossesMovesAlone) {
    std::vector<Surfel> leaves;
    for (int i = 0; i <= 20; ++i)
        for (int j = 0; j <= 20; ++j) leaves.push_back(disc({i / 20.0, j / 20.0, 0}, 0.02));
    leaves.push_back(disc({1, 0.5, 0}, 0.2));
    SurfelTreeData data = test::flat_tree(leaves, 2);
    set_drawn_bounds(data);
    const BeyondBox beyond = beyond_of(data);
    EXPECT_NEAR(beyond.box.hi.x, 1 + 0.2 * kHitTrim, 1e-6);
    EXPECT_EQ(beyond.box.lo, data.header.drawn.lo);
    EXPECT_EQ(beyond.box.hi.y, data.header.drawn.hi.y);
    EXPECT_EQ(beyond.places.size(), 384u);
}

TEST(DrawnBeyond, LooseLeavesCountIfTheyAreDrawn) {
    SurfelTreeData data = test::flat_tree({disc({0, 0, 0}, 0.01), disc({1, 0, 0}, 1)}, 2);
    data.nodes[2].flags |= kLoose;
    set_drawn_bounds(data);
    const Bbox box{{0, 0, 0}, {1, 0, 0}};
    EXPECT_EQ(drawn_beyond(data.view(), false, box).box.hi.x, 1);
    EXPECT_NEAR(drawn_beyond(data.view(), true, box).box.hi.x, 1 + kHitTrim, 1e-6);
}

}  // namespace
}  // namespace slim
