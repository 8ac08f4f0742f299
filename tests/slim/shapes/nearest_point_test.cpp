#include "slim/shapes/shape.h"

#include "slim/base/error.h"
#include "slim/base/hash.h"
#include "slim/shapes/foot_point.h"
#include "tests/slim/shapes/shape_support.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slim {
namespace {

using test::at, test::points_near;

TEST(FootPoint, OfATorusIsOnTheTubeBelow) {
    const Shape& torus = find_shape("torus");
    for (std::uint64_t i = 0; i < 200; ++i) {
        const double u = 6.2 * unit_interval(mix64(i)), v = 6.2 * unit_interval(mix64(~i));
        const double off = 0.3 * (unit_interval(mix64(i + 1000)) - 0.5);
        const auto on_tube = [&](double r) {
            const double rho = 1 + r * std::cos(v);
            return Vec3d{rho * std::cos(u), rho * std::sin(u), r * std::sin(v)};
        };
        const FootPoint foot = foot_point(torus, on_tube(0.35 + off));
        EXPECT_TRUE(foot.converged);
        EXPECT_NEAR(length(foot.point - on_tube(0.35)), 0, 1e-10);
        EXPECT_NEAR(foot.signed_distance, off, 1e-10);
    }
}

TEST(FootPoint, OfAnEllipsoidIsPerpendicularAndNearerThanTheGradientsGuess) {
    const Shape& ellipsoid = find_shape("ellipsoid");
    const test::Cloud cloud = test::sampled("ellipsoid", 300, 3);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        const Vec3d off = cloud.truth[i].normal * 0.1;
        const FootPoint foot = foot_point(ellipsoid, cloud.positions[i] + off);
        EXPECT_NEAR(length(foot.point - cloud.positions[i]), 0, 1e-9);
        EXPECT_NEAR(signed_distance(ellipsoid, cloud.positions[i] + off), 0.1, 1e-10);
    }
}

TEST(FootPoint, IsNotBeyondAnEdgeWhereTheGradientLeadsToTheSurfaceNearby) {
    // Newton alone ended on other parts of the sculpture, at 0.13 of its diagonal from points that
    // lie within 0.007 of it.
    const Shape& shape = find_shape("sculpture");
    for (const Vec3d& x :
         {Vec3d{0.283372, -0.619621, 0.103694}, Vec3d{0.262819, -0.617535, -0.188137},
          Vec3d{-0.261512, -0.665507, 0.224609}}) {
        const double first = std::abs(shape.value(x)) / length(shape.jet(x).gradient());
        const FootPoint foot = foot_point(shape, x);
        EXPECT_LT(std::abs(foot.signed_distance), 1.2 * first);
        EXPECT_NEAR(shape.value(foot.point), 0, 1e-10);
    }
}

TEST(FootPoint, OfNoisyPointsIsSeldomFartherThanWhereTheyComeFrom) {
    const Shape& shape = find_shape("sculpture");
    const test::Cloud cloud = test::sampled("sculpture", 20000, 1);
    int n_farther = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        const double draw = unit_interval(mix64(i)) - 0.5,
                     off = 0.02 * draw + std::copysign(0.001, draw);
        const FootPoint foot = foot_point(shape, cloud.positions[i] + cloud.truth[i].normal * off);
        const double farther = std::abs(foot.signed_distance / off);
        EXPECT_LT(farther, 3) << i;  // measured: 2.1; 26 before
        n_farther += farther > 1.001 ? 1 : 0;
    }
    EXPECT_LT(n_farther, 200);
}

TEST(FootPoint, IsNotThroughTheHeadAndOutAtTheFace) {
    // Gradient projection leads there, 0.21 away; measured: 0.029.
    const FootPoint foot =
        foot_point(find_shape("sculpture"), {-0.0508237705, 0.738359869, -0.10150709});
    EXPECT_LT(std::abs(foot.signed_distance), 0.03);
}

/// |distance| by the shape's nearest point; -1 if it is not known.
double distance_to(const char* name, const Vec3d& x) {
    const auto foot = nearest_point(find_shape(name), x);
    if (!foot) return -1;
    EXPECT_NEAR(std::abs(foot->signed_distance), length(x - foot->point), 1e-12 * length(x))
        << name;
    return std::abs(foot->signed_distance);
}

TEST(NearestPoint, OfMiddlesAndAxesIsARadiusAway) {
    // Feet on all sides, and no gradient: these counted as on the surface.
    EXPECT_DOUBLE_EQ(distance_to("sphere", {0, 0, 0}), 1);
    EXPECT_DOUBLE_EQ(distance_to("sphere", {1e-200, 0, 0}), 1);
    EXPECT_DOUBLE_EQ(distance_to("torus", {0, 0, 0}), 0.65);
    EXPECT_DOUBLE_EQ(distance_to("torus", {0, 0, 5}), std::sqrt(26.0) - 0.35);
    EXPECT_DOUBLE_EQ(distance_to("torus", {0.6, 0.8, 0}), 0.35);
    EXPECT_DOUBLE_EQ(distance_to("cylinder", {0, 0, 0.5}), 1);
    EXPECT_DOUBLE_EQ(distance_to("cone", {0, 0, 5}), 4);
    EXPECT_DOUBLE_EQ(distance_to("cone", {0, 0, 0}), 1 / std::sqrt(5.0));
    EXPECT_NEAR(distance_to("ellipsoid", {0, 0, 0}), 0.4, 1e-12);
    EXPECT_NEAR(distance_to("bumpy", {0, 0, 0}), 0.9, 1e-9);
    EXPECT_LT(nearest_point(find_shape("bumpy"), {0, 0, 0})->signed_distance, 0);
}

TEST(NearestPoint, IsFoundFromAfar) {
    // To less than the spacing of doubles there; 20 to 70 before, the steps of gradient projection.
    const Vec3d way{0.6, 0.0, 0.8}, up{0, 0, 1}, side{1, 0, 0};
    for (const double far : {5.0, 1e3, 1e6, 1e12, 1e25}) {
        const double tiny = 1e-12 + far * 1e-15;
        EXPECT_NEAR(distance_to("sphere", way * far), far - 1, tiny);
        EXPECT_NEAR(distance_to("ellipsoid", side * far), far - 1, tiny);
        EXPECT_NEAR(distance_to("ellipsoid", up * far), far - 0.4, tiny);
        EXPECT_NEAR(distance_to("torus", side * far), far - 1.35, tiny);
        EXPECT_NEAR(distance_to("cyclide", side * far), far - 1.2, tiny);
        EXPECT_NEAR(distance_to("cylinder", side * far), far - 1, tiny);
        EXPECT_NEAR(distance_to("plane", way * far), 0.8 * far, tiny);
    }
    // A support plane: the ellipsoid reaches |axes * way| that way.
    const double reach = length(Vec3d{0.6, 0, 0.4 * 0.8});
    EXPECT_NEAR(distance_to("ellipsoid", way * 1e6), 1e6 - reach, 1e-6);
}

TEST(NearestPoint, IsNotAFarPointBeyondACentreOfCurvature) {
    // The tip of the ellipsoid is stationary, 0.5 away; the nearest point has x = 0.5 / (1 - 0.16).
    const double x = 0.5 / 0.84, z = 0.4 * std::sqrt(1 - x * x);
    EXPECT_NEAR(distance_to("ellipsoid", {0.5, 0, 0}), std::hypot(x - 0.5, z), 1e-9);
}

TEST(NearestPoint, AcrossACreaseLiesOnIt) {
    // Beside the plinth's upper edge x = 0.46, y = -0.86, which runs along z; and its corner.
    const Vec3d edge{0.46, -0.86, 0.1}, corner{0.46, -1, 0.46};
    for (const double off : {0.001, 0.01, 0.1}) {
        EXPECT_NEAR(distance_to("sculpture", edge + Vec3d{off, off, 0}), off * std::sqrt(2.0),
                    1e-4);
        EXPECT_NEAR(distance_to("sculpture", corner + Vec3d{off, -off, off}), off * std::sqrt(3.0),
                    1e-4);
    }
}

TEST(NearestPoint, InsideASolidIsNotAtAnEdgeWithinIt) {
    // Where two parts overlap the value has an edge inside, at -0.02; there gradient projection
    // ended, and 0.0031 was the distance of a point that is 0.12 from the surface.
    const Shape& shape = find_shape("sculpture");
    const Vec3d x{-0.227850463, -0.876905319, -0.0716606202};
    const auto foot = nearest_point(shape, x);
    ASSERT_TRUE(foot);
    EXPECT_NEAR(shape.value(foot->point), 0, 1e-10);
    EXPECT_NEAR(foot->signed_distance, -(1 - 0.876905319), 1e-3);  // the base at y = -1
}

TEST(NearestPoint, IsUnknownWhereNothingTellsIt) {
    EXPECT_FALSE(nearest_point(find_shape("sphere"), {1e200, 0, 0}));
    EXPECT_FALSE(nearest_point(find_shape("ellipsoid"), {0, 1e200, 0}));
    EXPECT_FALSE(nearest_point(find_shape("monkey"), {1e6, 2e6, 3e6}));  // goes on beyond its box
    EXPECT_TRUE(nearest_point(find_shape("monkey"), {0.5, 0.1, 0.2}));
}

TEST(NearestPoint, AgreesWithTheFootOfPointsNearTheSurface) {
    for (const Shape& shape : all_shapes())
        for (const Vec3d& x : points_near(shape, 100)) {
            const FootPoint foot = foot_point(shape, x);
            const auto nearest = nearest_point(shape, x);
            ASSERT_TRUE(nearest) << shape.name;
            if (foot.converged) {
                EXPECT_DOUBLE_EQ(nearest->signed_distance, foot.signed_distance) << shape.name;
            }
        }
}

}  // namespace
}  // namespace slim
