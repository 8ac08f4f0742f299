#include "slim/fit/local_fit.h"

#include "tests/slim/fit/ball_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

namespace slim::test {
namespace {

TEST(AverageNormal, TakesTheSideOfTheCentre) {
    auto ball = ball_of<float>(400, 1, 9, [](double, double) { return 0.0; });
    for (std::size_t i = 0; i < ball.n; i += 3) ball.nz[i] = -1;
    EXPECT_NEAR(average_normal(ball, 1, {0, 0, 1}).normal.z, 1, 1e-12);
    EXPECT_NEAR(average_normal(ball, 1, {0.5, 0, -1}).normal.z, -1, 1e-12);
    EXPECT_FALSE(average_normal(ball, 1, {0, 0, 1}).disagree);
    std::vector<SetAside<float>> aside;
    auto down = ball, unmeasured = ball;
    set_contrary_aside(ball, {0, 0, 1}, aside);
    EXPECT_EQ(aside.size(), (ball.n + 2) / 3);
    set_contrary_aside(down, {0, 0, -1}, aside);
    EXPECT_EQ(aside.size(), ball.n - (ball.n + 2) / 3);
    for (std::size_t i = 0; i < ball.n; ++i) unmeasured.nz[i] = 0;
    set_contrary_aside(unmeasured, {0, 0, 1}, aside);
    EXPECT_TRUE(aside.empty());
}

TEST(AverageNormal, IsThatOfTheBallWhereNoiseTiltsTheCentres) {
    auto ball = ball_of<float>(4000, 1, 12, [](double, double) { return 0.0; });
    for (std::size_t i = 0; i < ball.n; ++i) {
        // Every direction of the upper half, as noise thicker than the spacing has it.
        const double angle = 2.399963 * static_cast<double>(i);
        const double z = (static_cast<double>(i) + 0.5) / static_cast<double>(ball.n);
        const double across = std::sqrt(1 - z * z);
        ball.nx[i] = static_cast<float>(across * std::cos(angle));
        ball.ny[i] = static_cast<float>(across * std::sin(angle));
        ball.nz[i] = static_cast<float>(z);
    }
    const Vec3d tilted = normalized(Vec3d{1, 0, -0.5});
    const BallNormal n = average_normal(ball, 1, tilted);
    EXPECT_FALSE(n.disagree);
    // Of those on the side of the centre's alone it is some 60 degrees off.
    EXPECT_GT(n.normal.z, 0.85);
}

TEST(AverageNormal, FallsBackOnTheLeastSpreadWhereNormalsDisagree) {
    auto ball = ball_of<double>(400, 1, 10, [](double u, double) { return 0.2 * u; });
    for (std::size_t i = 0; i < ball.n; ++i) {
        // In all directions of the plane, with a little to the side of the centre's.
        const double angle = 2.399963 * static_cast<double>(i);
        ball.nx[i] = static_cast<float>(std::cos(angle));
        ball.ny[i] = static_cast<float>(std::sin(angle));
        ball.nz[i] = 0.05f;
    }
    const BallNormal n = average_normal(ball, 1, {0, 0, 1});
    EXPECT_TRUE(n.disagree);
    EXPECT_NEAR(length(n.normal - normalized(Vec3d{-0.2, 0, 1})), 0, 1e-6);
    const BallNormal below = average_normal(ball, 1, normalized(Vec3d{0, 0, -1}));
    EXPECT_TRUE(below.disagree);
    EXPECT_LT(below.normal.z, 0);
}

TEST(AverageNormal, OfAnEmptyBallIsTheCentresOwn) {
    BallPoints<float> empty;
    const BallNormal n = average_normal(empty, 1, {0, 1, 0});
    EXPECT_EQ(n.normal, (Vec3d{0, 1, 0}));
    EXPECT_TRUE(n.disagree);
}

}  // namespace
}  // namespace slim::test
