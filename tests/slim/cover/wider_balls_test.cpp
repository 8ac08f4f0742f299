#include "slim/cover/wider_balls.h"

#include <gtest/gtest.h>

#include <vector>

namespace slim::test {
namespace {

/// A ball that holds points with these normals.
BallPoints<double> ball_of(const std::vector<Vec3f>& normals) {
    BallPoints<double> ball;
    ball.n = normals.size();
    ball.radius = 1;
    for (const Vec3f& n : normals) {
        ball.x.push_back(0), ball.y.push_back(0), ball.z.push_back(0), ball.sq.push_back(0);
        ball.nx.push_back(n.x), ball.ny.push_back(n.y), ball.nz.push_back(n.z);
    }
    return ball;
}

const Vec3f kUp{0, 0, 1}, kDown{0, 0, -1}, kAside{1, 0, 0};

TEST(WiderBalls, ShareSidewaysIsOfThePointsThatDoNotFaceAway) {
    EXPECT_EQ(share_sideways(ball_of({kUp, kUp, kUp}), {0, 0, 1}), 0);
    EXPECT_EQ(share_sideways(ball_of({kUp, kUp, kUp, kAside}), {0, 0, 1}), 0.25);
    EXPECT_EQ(
        share_sideways(ball_of({kUp, kUp, kUp, kAside, kDown, kDown, kDown, kDown}), {0, 0, 1}),
        0.25);
    EXPECT_EQ(share_sideways(ball_of({kUp, kDown}), {1, 0, 0}), 1);
}

TEST(WiderBalls, ShareSidewaysOfAPlatesOtherSideAloneIsNone) {
    EXPECT_EQ(share_sideways(ball_of({kDown, kDown}), {0, 0, 1}), 0);
    EXPECT_EQ(share_sideways(ball_of({}), {0, 0, 1}), 0);
}

TEST(WiderBalls, ShareSidewaysLeavesOutPadding) {
    BallPoints<double> ball = ball_of({kUp, kAside, kAside, kAside});
    ball.n = 2;
    EXPECT_EQ(share_sideways(ball, {0, 0, 1}), 0.5);
}

}  // namespace
}  // namespace slim::test
