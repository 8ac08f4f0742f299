#include "slim/fit/sheet_by_normals.h"

#include "slim/fit/sharp_fit.h"
#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace slim::test {
namespace {

/// A few points of w = 0.1 + 0.2 u - 0.1 v + 0.3 u^2 - 0.2 u v + 0.1 v^2, with its normals.
PointBlock quadric_points(std::size_t n) {
    PointBlock block = graph_points(n, 0.6, 4, [](double u, double v) {
        return 0.1 + 0.2 * u - 0.1 * v + 0.3 * u * u - 0.2 * u * v + 0.1 * v * v;
    });
    for (std::size_t i = 0; i < n; ++i) {
        const double u = block.position[i].x, v = block.position[i].y;
        block.normal[i] =
            to_float(normalized(Vec3d{-(0.2 + 0.6 * u - 0.2 * v), -(-0.1 - 0.2 * u + 0.2 * v), 1}));
    }
    return block;
}

BallPoints<double> ball_of(const PointBlock& block) {
    BallPoints<double> ball;
    gather_ball(tree_of(block), {}, 1, ball);
    return ball;
}

TEST(SheetByNormals, AFewPointsWithNormalsMakeAQuadric) {
    const auto fit = fit_by_normals(ball_of(quadric_points(7)), frame_from_normal(Vec3d{0, 0, 1}));
    ASSERT_TRUE(fit);
    EXPECT_EQ(fit->degree, 2);
    const Frame<double> frame = frame_from_normal(Vec3d{0, 0, 1});
    for (std::size_t i = 0; i < 50; ++i) {
        const double x = 0.6 * random_at(9, 2 * i), y = 0.6 * random_at(9, 2 * i + 1);
        const Vec3d local = frame.local_from_world(Vec3d{x, y, 0});
        const double truth = 0.1 + 0.2 * x - 0.1 * y + 0.3 * x * x - 0.2 * x * y + 0.1 * y * y;
        // Normals are floats, and seven points say little beyond them.
        EXPECT_NEAR(fit->polynomial.value(local.x, local.y), truth, 1e-4);
    }
    EXPECT_LT(fit->sq_error, 1e-12);
}

TEST(SheetByNormals, WithoutNormalsOrWithTooFewPointsThereIsNone) {
    PointBlock block = quadric_points(7);
    for (Vec3f& n : block.normal) n = {};
    EXPECT_FALSE(fit_by_normals(ball_of(block), frame_from_normal(Vec3d{0, 0, 1})));
    EXPECT_FALSE(fit_by_normals(ball_of(quadric_points(5)), frame_from_normal(Vec3d{0, 0, 1})));
    EXPECT_FALSE(fit_by_normals(BallPoints<double>{}, frame_from_normal(Vec3d{0, 0, 1})));
}

TEST(SheetByNormals, AFaceThatCurvesAwayAlongAnEdgeTakesAQuadricOfFewPoints) {
    // The plane z = 0 above a wall: a cylinder of radius 0.8 about an axis along z. Ten points of
    // the wall and five of the edge are no quadric by themselves, under G.
    constexpr double kRadius = 0.8;
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (const double t : {-0.6, -0.3, 0.0, 0.3, 0.6}) {
        const Vec3d n{std::cos(t), std::sin(t), 0}, on_edge = (n - Vec3d{1, 0, 0}) * kRadius;
        positions.push_back(on_edge), normals.push_back(to_float(normalized(n + Vec3d{0, 0, 1})));
        for (const double z : {-0.3, -0.6})
            positions.push_back(on_edge + Vec3d{0, 0, z}), normals.push_back(to_float(n));
        for (const double x : {-0.3, -0.6})
            positions.push_back(on_edge + n * x), normals.push_back({0, 0, 1});
    }
    const BallPoints<double> ball = ball_of(block_of(positions, normals));
    SharpWork<double> work;
    const auto fit = fit_sharp(ball, 2, 2, 0, work);
    ASSERT_TRUE(fit);
    EXPECT_EQ(fit->degree, 2);
    EXPECT_EQ(fit->outer, Join::max);
    const Surfel s = fit->surfel({}, 1);
    for (double t = -0.6; t <= 0.6; t += 0.1) {
        const Vec3d on_wall =
            (Vec3d{std::cos(t), std::sin(t), 0} - Vec3d{1, 0, 0}) * kRadius - Vec3d{0, 0, 0.1};
        EXPECT_NEAR(s.value(on_wall), 0, 0.05) << t;  // planes: 0.1 at the ends
    }
}

}  // namespace
}  // namespace slim::test
