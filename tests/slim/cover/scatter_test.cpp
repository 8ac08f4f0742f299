#include "slim/cover/scatter.h"

#include <gtest/gtest.h>

#include <cstddef>

namespace slim::test {
namespace {

/// A leaf that covers n points, the farthest of them that far from its centre, over rho.
CoveringSurfel leaf_of(std::size_t n, float farthest) {
    CoveringSurfel leaf;
    leaf.covered.resize(n);
    for (std::size_t i = 0; i + 1 < n; ++i) leaf.covered[i].u = leaf.covered[i].v = 0.1f * farthest;
    leaf.covered.back().u = 0.6f * farthest;
    leaf.covered.back().v = -0.8f * farthest;
    return leaf;
}

TEST(Scatter, LeavesOfFewPointsReachALittleBeyondTheLast) {
    EXPECT_NEAR(share_of_few(leaf_of(2, 0.5f)), 0.575, 1e-6);
    EXPECT_NEAR(share_of_few(leaf_of(7, 0.2f)), 0.23, 1e-6);
    EXPECT_EQ(share_of_few(leaf_of(7, 0.95f)), 1);
    EXPECT_EQ(share_of_few(leaf_of(5, 1e-6f)), 0.1);
}

TEST(Scatter, LeavesOfMorePointsOrOfOneKeepTheirRadius) {
    EXPECT_EQ(share_of_few(leaf_of(8, 0.2f)), 1);
    EXPECT_EQ(share_of_few(leaf_of(1, 0.2f)), 1);
}

}  // namespace
}  // namespace slim::test
