#include "raytrace/intersect/quadratic_in_ball.h"

#include "slim/blend/roots.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>

namespace slim {
namespace {

using Pair = std::array<float, 2>;

/// (t - a) (t - b), in all lanes.
PolynomialLanes<FloatV> with_roots(const Pair& roots, float sign) {
    return {FloatV(sign * roots[0] * roots[1]), FloatV(-sign * (roots[0] + roots[1])), FloatV(sign),
            FloatV(0.0f)};
}

/// |t - middle| < radius.
BallLanes<FloatV> ball_about(float middle, float radius) {
    return {FloatV(middle * middle - radius * radius), FloatV(-2 * middle), FloatV(1.0f)};
}

// The middle of the roots on either side of 0 and at it, and both signs of the polynomial: each way
// to the sign of h.
TEST(QuadraticInBall, FindsTheNearestRootOnEitherSide) {
    for (const float sign : {1.0f, -1.0f})
        for (const auto& [a, b] :
             {Pair{0.3f, 5.0f}, Pair{-0.3f, -5.0f}, Pair{-0.3f, 2.0f}, Pair{0.3f, -2.0f}}) {
            const auto root = nearest_quadratic_in_ball<FloatV>(
                with_roots({a, b}, sign), ball_about(0, 1), 10, FloatV::mask_type(true));
            ASSERT_TRUE(stdx::all_of(root.hit)) << sign << ' ' << a;
            for (std::size_t k = 0; k < FloatV::size(); ++k)
                ASSERT_NEAR(root.t[k], a, 1e-6f) << sign << ' ' << b;
        }
}

TEST(QuadraticInBall, TakesTheFartherRootWhereTheNearerIsOutsideTheBall) {
    for (const float sign : {1.0f, -1.0f})
        for (const float turn : {1.0f, -1.0f}) {
            const auto root = nearest_quadratic_in_ball<FloatV>(
                with_roots({0.3f * turn, 2 * turn}, sign), ball_about(2 * turn, 0.5f), 10,
                FloatV::mask_type(true));
            ASSERT_TRUE(stdx::all_of(root.hit));
            for (std::size_t k = 0; k < FloatV::size(); ++k)
                ASSERT_NEAR(root.t[k], 2 * turn, 2e-6f);
        }
}

TEST(QuadraticInBall, FindsTheFirstOfTwoRootsThatLieAlike) {
    for (const float sign : {1.0f, -1.0f}) {
        const auto root = first_quadratic_in_ball<FloatV>(with_roots({-0.5f, 0.5f}, sign),
                                                          ball_about(0, 1), 10, -10.0f);
        ASSERT_TRUE(stdx::all_of(root.hit));
        for (std::size_t k = 0; k < FloatV::size(); ++k) ASSERT_NEAR(root.t[k], -0.5f, 1e-6f);
    }
}

TEST(QuadraticInBall, AnExactTangentIsAHitAsInRoots) {
    for (const float sign : {1.0f, -1.0f})
        for (const float at : {0.0f, 0.5f, -0.25f, 0.75f}) {
            SCOPED_TRACE(testing::Message() << sign << " at " << at);
            const auto k = with_roots({at, at}, sign);
            EXPECT_EQ(quadratic_roots<float>(k[0][0], k[1][0], k[2][0], -1, 1).first(), at);
            for (const auto& root :
                 {first_quadratic_in_ball<FloatV>(k, ball_about(0, 1), 10, -10.0f),
                  nearest_quadratic_in_ball<FloatV>(k, ball_about(0, 1), 10,
                                                    FloatV::mask_type(true))}) {
                EXPECT_TRUE(stdx::all_of(root.hit));
                for (std::size_t lane = 0; lane < FloatV::size(); ++lane)
                    EXPECT_NEAR(root.t[lane], at, 1e-6f);
            }
        }
}

TEST(QuadraticInBall, HasNoRootWhereTheDiscriminantIsNegative) {
    PolynomialLanes<FloatV> none = with_roots({0.5f, 0.5f}, 1);
    none[0] = FloatV(1.0f);
    EXPECT_TRUE(
        stdx::none_of(first_quadratic_in_ball<FloatV>(none, ball_about(0, 1), 10, -10.0f).hit));
    EXPECT_TRUE(stdx::none_of(
        nearest_quadratic_in_ball<FloatV>(none, ball_about(0, 1), 10, FloatV::mask_type(true))
            .hit));
}

}  // namespace
}  // namespace slim
