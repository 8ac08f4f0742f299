#include "slim/fit/parallel_sheet.h"

#include "tests/slim/fit/ball_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace slim::test {
namespace {

constexpr double kExplained = 1e-4;  // eps^2

/// A ball of a flat sheet that faces up and of one 0.3 radii below it that faces down, both of
/// n points in the square about the ball, those that `has` leaves out.
template <class Has>
SheetEnd end_of(std::size_t n, Vec3f lower_normal, const Has& has, double rough = 0) {
    const PointBlock upper = graph_points(n, 1, 1, [&](double u, double v) {
        return rough * (std::sin(1e4 * u) + std::sin(1e4 * v));  // of variance rough^2
    });
    const PointBlock lower = graph_points(n, 1, 2, [](double, double) { return -0.3; });
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    const auto add = [&](const PointBlock& sheet, const Vec3f& normal) {
        for (const Vec3d& p : sheet.position)
            if (has(p)) positions.push_back(p), normals.push_back(normal);
    };
    add(upper, {0, 0, 1});
    add(lower, lower_normal);
    BallPoints<double> ball;
    gather_ball(tree_of(block_of(std::move(positions), std::move(normals))), {0, 0, 0}, 1, ball);
    std::vector<SetAside<double>> aside;
    set_contrary_aside(ball, {0, 0, 1}, aside);
    const LocalFit fit = fit_ball(ball, 1, kUpright, 2);
    return end_of_sheet<double>(ball, aside, {kUpright, fit, kExplained, 0.1, 0});
}

bool everywhere(const Vec3d&) { return true; }

TEST(ParallelSheet, GoesOnPastTheOtherSide) {
    EXPECT_EQ(end_of(100, {0, 0, -1}, everywhere), SheetEnd::goes_on);
    EXPECT_EQ(end_of(2000, {0, 0, -1}, everywhere), SheetEnd::goes_on);
}

TEST(ParallelSheet, EndsAtALineWhereTheSheetTurnsRound) {
    const auto cut_at = [](double x) {
        return end_of(2000, {0, 0, -1}, [x](const Vec3d& p) { return p.x < x; });
    };
    EXPECT_EQ(cut_at(-0.1), SheetEnd::ends);
    EXPECT_EQ(cut_at(0), SheetEnd::ends);
    EXPECT_NE(cut_at(0.15), SheetEnd::goes_on);
    EXPECT_EQ(cut_at(0.5), SheetEnd::goes_on);  // the leaf's rim ends there
}

TEST(ParallelSheet, EndsWherePointsFaceSideways) {
    EXPECT_EQ(end_of(400, {1, 0, 0}, everywhere), SheetEnd::ends);
}

TEST(ParallelSheet, EndsWhereItsPointsAreNotExplained) {
    EXPECT_EQ(end_of(400, {0, 0, -1}, everywhere, 0.01), SheetEnd::goes_on);
    EXPECT_EQ(end_of(400, {0, 0, -1}, everywhere, 0.03), SheetEnd::ends);
}

TEST(ParallelSheet, AFewPointsLeaveInDoubt) {
    EXPECT_EQ(end_of(20, {0, 0, -1}, everywhere), SheetEnd::in_doubt);
}

}  // namespace
}  // namespace slim::test
