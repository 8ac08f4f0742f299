#include "slim/tree/ball_links.h"

#include "slim/model/surfel_tree.h"

#include <gtest/gtest.h>

#include <vector>

namespace slim {
namespace {

LinkedBall internal(const Vec3d& center, double radius, int level) {
    return {center, radius, static_cast<std::uint8_t>(level), 0, 2, 0};
}
LinkedBall leaf(const Vec3d& center, double radius, int level) {
    return {center, radius, static_cast<std::uint8_t>(level), kLeaf, 2, 0};
}

using Parents = std::vector<std::uint32_t>;

TEST(BallLinks, TakeTheNearestOfTheLevelAbove) {
    const std::vector<LinkedBall> balls{internal({0, 0, 0}, 1, 1), internal({1.5, 0, 0}, 1, 1),
                                        leaf({0.7, 0, 0}, 0.6, 2), leaf({0.8, 0, 0}, 0.6, 2)};
    const BallLinks links = link_balls(balls);
    EXPECT_EQ(links.parent, (Parents{kNoNode, kNoNode, 0, 1}));
    EXPECT_EQ(links.n_orphans, 0u);
}

// A close-up in a coarse cloud: only it has balls of the fine levels.
TEST(BallLinks, OrphansHangOnACoarserBallThatHoldsThem) {
    const std::vector<LinkedBall> balls{
        internal({0, 0, 0}, 1, 1), internal({2, 0, 0}, 1, 1),  // the cloud
        internal({0, 0, 0}, 0.6, 2), internal({0, 0, 0}, 0.2, 4),  // the close-up
        leaf({0.1, 0, 0}, 0.1, 5),  // of it
        leaf({2.3, 0, 0}, 0.6, 5),  // of the cloud, at a late level
        leaf({0.6, 0, 0}, 0.3, 5),  // beside it: two levels up
    };
    const BallLinks links = link_balls(balls);
    EXPECT_EQ(links.parent, (Parents{kNoNode, kNoNode, 0, 2, 3, 1, 2}));
    EXPECT_EQ(links.n_orphans, 2u);
}

TEST(BallLinks, ALargeLeafHangsOnNoSmallBallThoughItHoldsItsCentre) {
    const std::vector<LinkedBall> balls{internal({0, 0, 0}, 1, 1), internal({0, 0, 0}, 0.1, 3),
                                        leaf({0.05, 0, 0}, 0.5, 4)};
    EXPECT_EQ(link_balls(balls).parent, (Parents{kNoNode, 0, 0}));
}

TEST(BallLinks, WhatNoBallHoldsHangsOnTheRoot) {
    const std::vector<LinkedBall> balls{internal({0, 0, 0}, 1, 1), leaf({3, 0, 0}, 0.5, 2),
                                        internal({0, 3, 0}, 0.6, 2), leaf({0, 3, 0}, 0.2, 3)};
    const BallLinks links = link_balls(balls);
    EXPECT_EQ(links.parent, (Parents{kNoNode, kNoNode, kNoNode, 2}));
    EXPECT_EQ(links.n_orphans, 2u);
}

}  // namespace
}  // namespace slim
