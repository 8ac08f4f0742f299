#include "slim/smooth/point_projector.h"

#include "slim/base/hash.h"
#include "slim/smooth/smoothing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

namespace slim {
namespace {

constexpr double kThickness = 0.04;

double random(std::uint64_t key, std::uint64_t what) {
    return 2 * unit_interval(keyed_hash(5, key, what)) - 1;
}

/// Leaves of both sides of a thin plate, whose balls reach over it; more of them below.
std::vector<Surfel> plate() {
    std::vector<Surfel> leaves;
    for (std::uint64_t i = 0; i < 500; ++i) {
        const bool top = i % 3 == 0;
        Surfel s{{random(i, 1), random(i, 2), top ? kThickness : 0},
                 0.3 + 0.05 * random(i, 3),
                 frame_from_normal(Vec3d{0, 0, top ? 1.0 : -1.0}),
                 {},
                 2};
        leaves.push_back(s);
    }
    return leaves;
}

/// A point near a side, by chance 0.2 of the thickness off it.
Vec3d near_side(std::uint64_t i, bool top) {
    return {0.5 * random(i, 6), 0.5 * random(i, 7),
            (top ? kThickness : 0) + 0.2 * kThickness * random(i, 8)};
}

TEST(PointProjector, APointWithoutANormalStaysOnItsSideOfAThinPlate) {
    const BallIndex index(plate());
    PointProjector projector(index);
    for (std::uint64_t i = 0; i < 300; ++i) {
        const bool top = i % 2 == 0;
        const Vec3d p = near_side(i, top);
        const ProjectedPoint put = projector.project(p, {});
        ASSERT_TRUE(put.hit) << i;
        EXPECT_NEAR(put.hit->point.z, top ? kThickness : 0, 1e-12) << i;
        EXPECT_GT(dot(put.direction, Vec3d{0, 0, top ? 1.0 : -1.0}), 0.999);
        EXPECT_FALSE(put.opposed);
        EXPECT_FALSE(put.astray);
    }
}

TEST(PointProjector, SmoothingCarriesNoPointThroughAThinPlate) {
    const BallIndex index(plate());
    std::vector<Vec3d> points;
    for (std::uint64_t i = 0; i < 2000; ++i) points.push_back(near_side(i, i % 2 == 0));
    std::vector<SmoothedPoint> out(points.size());
    smooth_points({index}, {}, points, {}, out);
    for (std::size_t i = 0; i < out.size(); ++i) {
        ASSERT_TRUE(out[i].moved);
        EXPECT_NEAR(out[i].position.z, i % 2 == 0 ? kThickness : 0, 1e-9) << i;
        EXPECT_FALSE(out[i].opposed);
    }
}

TEST(PointProjector, APointsOwnNormalDecidesItsSide) {
    const BallIndex index(plate());
    PointProjector projector(index);
    const ProjectedPoint up = projector.project({0, 0, 0.001}, {0, 0, 1});
    ASSERT_TRUE(up.hit);
    EXPECT_NEAR(up.hit->point.z, kThickness, 1e-12);
}

}  // namespace
}  // namespace slim
