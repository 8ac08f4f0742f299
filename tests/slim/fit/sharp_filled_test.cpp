#include "slim/fit/sharp_filled.h"

#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

namespace slim::test {
namespace {

/// A level face inside a profile and a wall below it: the profile goes straight up to y = 0.1 and then round by an arc
/// of that radius (0: straight on). Points on a grid, those of the edge with the mean normal of the faces. The other way
/// round (`convex` false) the same as the bottom of a hollow.
PointBlock wall_points(double arc_radius, bool convex) {
    constexpr double kStep = 0.16;
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    const double side = convex ? 1 : -1;
    for (int i = -8; i <= 8; ++i) {
        const double s = kStep * i, t = arc_radius > 0 && s > 0.1 ? (s - 0.1) / arc_radius : 0;
        const Vec3d n{std::cos(t), std::sin(t), 0};
        const Vec3d at = t > 0 ? Vec3d{arc_radius * (n.x - 1), 0.1 + arc_radius * n.y, 0} : Vec3d{0, s, 0};
        positions.push_back(at), normals.push_back(to_float(normalized(n + Vec3d{0, 0, 1}) * side));
        for (int k = 1; k <= 7; ++k) {
            positions.push_back(at - Vec3d{0, 0, kStep * k}), normals.push_back(to_float(n * side));
            if (t > 0) continue;
            positions.push_back(at - n * (kStep * k)), normals.push_back(to_float(Vec3d{0, 0, side}));
        }
    }
    return block_of(positions, normals);
}

/// Whether two planes through the edge, fitted to the straight part, are borne out by all points.
bool planes_are_filled(double arc_radius, bool convex, double noise_variance = 0) {
    SharpWork<double> work;
    BallPoints<double> straight, ball;
    gather_ball(tree_of(wall_points(0, convex)), {}, 1, straight);
    gather_ball(tree_of(wall_points(arc_radius, convex)), {}, 1, ball);
    const auto fit = fit_sharp(straight, 2, 1, 0, work);
    EXPECT_TRUE(fit);
    EXPECT_EQ(fit->outer, convex ? Join::max : Join::min);
    return is_filled(*fit, ball, noise_variance);
}

TEST(SharpFilled, PlanesOfAStraightEdgeAreBorneOut) {
    EXPECT_TRUE(planes_are_filled(0, true));
    EXPECT_TRUE(planes_are_filled(0, false));
}

TEST(SharpFilled, WhereAFaceCurvesAwayPlanesStandOut) {
    EXPECT_FALSE(planes_are_filled(0.5, true));
    EXPECT_FALSE(planes_are_filled(0.5, false));
}

TEST(SharpFilled, WhatNoiseExplainsDoesNotStandOut) {
    // The planes are off by 0.28 at the core's end.
    EXPECT_TRUE(planes_are_filled(0.5, true, 0.25 * 0.25));
}

TEST(SharpFilled, SheetsThatRunBeyondTheirPointsAreNotFilled) {
    // The same edge with points up to y = -0.1 only.
    PointBlock block = wall_points(0, true);
    SharpWork<double> work;
    BallPoints<double> whole, ball;
    gather_ball(tree_of(block), {}, 1, whole);
    const auto fit = fit_sharp(whole, 2, 1, 0, work);
    ASSERT_TRUE(fit);
    EXPECT_TRUE(is_filled(*fit, whole, 0));
    PointBlock half;
    for (std::size_t i = 0; i < block.size(); ++i) {
        if (block.position[i].y > -0.1) continue;
        half.position.push_back(block.position[i]), half.normal.push_back(block.normal[i]), half.id.push_back(i);
    }
    gather_ball(tree_of(half), {}, 1, ball);
    EXPECT_FALSE(is_filled(*fit, ball, 0));
}

}  // namespace
}  // namespace slim::test
