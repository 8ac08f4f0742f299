#include "slim/cover/far_points.h"

#include "slim/base/parallel.h"
#include "tests/slim/cover/cover_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace slim::test {
namespace {

/// A plane of points and the flat leaf over it; the point of number `far` stands off.
struct Scene {
    PointBlock block;
    Surfel leaf{{0, 0, 0}, 1, frame_from_normal(Vec3d{0, 0, 1}), {}, 2};
    std::size_t far = 0;  // in the block

    explicit Scene(double off) {
        block = along_curve(graph_points(3000, 1, 3, [](double, double) { return 0.0; }));
        for (Vec3f& n : block.normal) n = {0, 0, 1};
        while (std::hypot(block.position[far].x, block.position[far].y) > 0.3) ++far;
        block.position[far].z = off;
    }
    std::vector<const Surfel*> leaves() const { return {&leaf}; }
};

std::vector<std::uint32_t> all_places(const PointTree& tree) {
    std::vector<std::uint32_t> out(tree.size());
    for (std::uint32_t i = 0; i < out.size(); ++i) out[i] = i;
    return out;
}

TEST(FarPoints, ThoseThatTheBlendPassesByAndThoseThatNoLeafMeets) {
    const Scene scene(0.02);
    const PointTree tree = tree_of(scene.block);
    std::size_t n_far = 0, n_unmet = 0, n_outside = 0;
    for (const FarPoint& p : far_points(tree, all_places(tree), scene.leaves(), 0.01)) {
        if (std::isinf(p.off)) {
            EXPECT_GE(length(tree.position(p.place)), 1) << "only outside the ball";
            ++n_unmet;
            continue;
        }
        EXPECT_EQ(tree.source(p.place), scene.far);
        EXPECT_NEAR(p.off, 0.02, 1e-12);
        ++n_far;
    }
    EXPECT_EQ(n_far, 1u);
    for (const Vec3d& p : scene.block.position) n_outside += length(p) >= 1;
    EXPECT_GT(n_outside, 0u);
    EXPECT_EQ(n_unmet, n_outside);
    EXPECT_EQ(far_points(tree, all_places(tree), scene.leaves(), 0.03).size(), n_outside);
}

// Along a normal that leans by 60 degrees a surface is twice as far as it is high.
TEST(FarPoints, DistanceIsAlongThePointsOwnNormal) {
    Scene scene(0.008);
    scene.block.normal[scene.far] = {static_cast<float>(std::sqrt(0.75)), 0, 0.5f};
    const PointTree tree = tree_of(scene.block);
    const auto may_be = maybe_far(tree, scene.leaves(), 0.01);
    bool found = false;
    for (const FarPoint& p : far_points(tree, may_be, scene.leaves(), 0.01)) {
        if (std::isinf(p.off)) continue;
        EXPECT_EQ(tree.source(p.place), scene.far);
        EXPECT_NEAR(p.off, 0.016, 1e-6);  // normals are kept to 1e-3 degrees
        found = true;
    }
    EXPECT_TRUE(found);
}

// A look at few places finds what a look at all does.
TEST(FarPoints, WhatMayBeFarHoldsAllThatIs) {
    const PointBlock block = block_of(sampled("sculpture", 10000));
    CoverRules rules = rules_for(block, 0.03);
    const auto fitted = leaves_of(cover(block, rules));
    std::vector<const Surfel*> leaves;
    for (const FittedSurfel& f : fitted) leaves.push_back(&f.surfel);
    const PointTree tree = tree_of(block);
    const double farthest = 4 * std::sqrt(rules.noise_variance);
    const auto may_be = maybe_far(tree, leaves, farthest);
    EXPECT_LT(may_be.size(), tree.size() / 2);
    const auto few = far_points(tree, may_be, leaves, farthest),
               all = far_points(tree, all_places(tree), leaves, farthest);
    ASSERT_GT(all.size(), 0u);
    ASSERT_EQ(few.size(), all.size());
    for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(few[i].place, all[i].place);
    const ThreadLimit limit(1);
    EXPECT_EQ(maybe_far(tree, leaves, farthest), may_be);
}

}  // namespace
}  // namespace slim::test
