#include "slim/fit/sharp_filled.h"

#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

namespace slim::test {
namespace {

/// A level face inside a profile and a wall below it: the profile goes straight up to y = 0.1 and
/// then round by an arc of that radius (0: straight on). Points on a grid, those of the edge with
/// the mean normal of the faces. The other way round (`convex` false) the same as the bottom of a
/// hollow.
PointBlock wall_points(double arc_radius, bool convex) {
    constexpr double kStep = 0.16;
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    const double side = convex ? 1 : -1;
    for (int i = -8; i <= 8; ++i) {
        const double s = kStep * i, t = arc_radius > 0 && s > 0.1 ? (s - 0.1) / arc_radius : 0;
        const Vec3d n{std::cos(t), std::sin(t), 0};
        const Vec3d at =
            t > 0 ? Vec3d{arc_radius * (n.x - 1), 0.1 + arc_radius * n.y, 0} : Vec3d{0, s, 0};
        positions.push_back(at), normals.push_back(to_float(normalized(n + Vec3d{0, 0, 1}) * side));
        for (int k = 1; k <= 7; ++k) {
            positions.push_back(at - Vec3d{0, 0, kStep * k}), normals.push_back(to_float(n * side));
            if (t > 0) continue;
            positions.push_back(at - n * (kStep * k)),
                normals.push_back(to_float(Vec3d{0, 0, side}));
        }
    }
    return block_of(positions, normals);
}

BallPoints<double> ball_of(const PointBlock& block) {
    BallPoints<double> ball;
    gather_ball(tree_of(block), {}, 1, ball);
    return ball;
}

/// Two planes through the straight edge.
SharpFit straight_edge(bool convex) {
    SharpWork<double> work;
    const auto fit = fit_sharp(ball_of(wall_points(0, convex)), 2, 1, 0, work);
    EXPECT_TRUE(fit);
    EXPECT_EQ(fit->outer, convex ? Join::max : Join::min);
    return *fit;
}

/// Whether two planes through the edge, fitted to the straight part, are borne out by all points.
bool planes_are_filled(double arc_radius, bool convex, double noise_variance = 0) {
    return is_filled(straight_edge(convex), ball_of(wall_points(arc_radius, convex)),
                     noise_variance);
}

TEST(SharpFilled, PlanesOfAStraightEdgeAreBorneOutByPointsThatFaceTheirWay) {
    EXPECT_TRUE(planes_are_filled(0, true));
    EXPECT_TRUE(planes_are_filled(0, false));
    // A hollow's points are in the same places, with contrary normals.
    EXPECT_FALSE(is_filled(straight_edge(true), ball_of(wall_points(0, false)), 0));
    EXPECT_FALSE(is_filled(straight_edge(false), ball_of(wall_points(0, true)), 0));
}

TEST(SharpFilled, WhereAFaceCurvesAwayPlanesStandOut) {
    EXPECT_FALSE(planes_are_filled(0.5, true));
    EXPECT_FALSE(planes_are_filled(0.5, false));
}

TEST(SharpFilled, WhatNoiseExplainsDoesNotStandOut) {
    // The planes are off by 0.28 at the core's end and stand out of those of the points near by
    // 0.15 at most: less than 0.05 and 2.5 deviations of the larger noise, more than of the
    // smaller.
    EXPECT_TRUE(planes_are_filled(0.5, true, 0.25 * 0.25));
    EXPECT_FALSE(planes_are_filled(0.5, true, 0.03 * 0.03));
}

TEST(SharpFilled, SheetsThatRunBeyondTheirPointsAreNotFilled) {
    // The same edge with points up to y = -0.1 only.
    const PointBlock block = wall_points(0, true);
    const SharpFit fit = straight_edge(true);
    EXPECT_TRUE(is_filled(fit, ball_of(block), 0));
    PointBlock half;
    for (std::size_t i = 0; i < block.size(); ++i) {
        if (block.position[i].y > -0.1) continue;
        half.position.push_back(block.position[i]);
        half.normal.push_back(block.normal[i]);
        half.id.push_back(i);
    }
    EXPECT_FALSE(is_filled(fit, ball_of(half), 0));
}

}  // namespace
}  // namespace slim::test
