#include "formats/face_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

// Points on single faces.

namespace slim::test {
namespace {

/// Points of one face beside many small ones, whose edges are 0.05.
std::vector<FacePoints::Point> of_face(const std::vector<Vec3d>& face) {
    const std::vector<Vec3d> small{{9, 0, 0}, {9.05, 0, 0}, {9, 0.05, 0}};
    std::vector<std::size_t> vertices(face.size());
    FacePoints faces;
    faces.measure(face);
    for (int k = 0; k < 200; ++k) faces.measure(small);
    faces.choose_spacing(10, 12500);
    std::vector<FacePoints::Point> out;
    faces.sample(face, vertices, out);
    return out;
}

/// The farthest that a place of a grid that is in the face is from the nearest point.
template <class IsInside>
double largest_gap(const std::vector<FacePoints::Point>& points, const IsInside& is_inside) {
    double gap = 0;
    for (double x = -1; x <= 1; x += 0.04)
        for (double y = -1; y <= 1; y += 0.04) {
            if (!is_inside(x, y)) continue;
            double nearest = 10;
            for (const auto& p : points)
                nearest = std::min(nearest, length(p.position - Vec3d{x, y, 0}));
            gap = std::max(gap, nearest);
        }
    return gap;
}

TEST(FacePoints, AFaceOfManyShortEdgesIsLarge) {
    std::vector<Vec3d> round;
    for (int k = 0; k < 128; ++k)
        round.push_back({std::cos(2 * M_PI * k / 128), std::sin(2 * M_PI * k / 128), 0});
    const auto points = of_face(round);
    EXPECT_LT(largest_gap(points, [](double x, double y) { return x * x + y * y < 0.95; }), 0.15);
}

TEST(FacePoints, AConcaveFaceIsCoveredAndNothingBesideIt) {
    // An L, from a corner from which a fan folds over.
    const std::vector<Vec3d> corners{{1, -1, 0}, {1, 0, 0}, {0, 0, 0},
                                     {0, 1, 0},  {-1, 1, 0}, {-1, -1, 0}};
    const auto is_inside = [](double x, double y) {
        return std::abs(x) < 0.99 && std::abs(y) < 0.99 && (x < -0.01 || y < -0.01);
    };
    for (std::size_t first = 0; first < corners.size(); ++first) {
        std::vector<Vec3d> face = corners;
        std::rotate(face.begin(), face.begin() + static_cast<std::ptrdiff_t>(first), face.end());
        const auto points = of_face(face);
        EXPECT_LT(largest_gap(points, is_inside), 0.15) << first;
        for (const auto& p : points) {
            ASSERT_FALSE(p.position.x > 1e-9 && p.position.y > 1e-9) << first;
            ASSERT_EQ(p.normal, (Vec3d{0, 0, 1}));
        }
    }
}

TEST(FacePoints, AFoldedFaceGetsNoMoreThanItsTrianglesAsk) {
    // Both halves of the quadrangle are 0.5 large, their vectors cancel to 1e-12.
    const std::vector<Vec3d> folded{{0, 0, 0}, {1e-12, 0, -1}, {0, 1, 0}, {-1e-12, 0, -1}};
    const std::vector<Vec3d> tiny{{2, 0, 0}, {2 + 1e-9, 0, 0}, {2, 1e-9, 0}};
    const std::vector<std::size_t> vertices{0, 1, 2, 3};
    FacePoints faces;
    faces.measure(folded);
    for (int k = 0; k < 3; ++k) faces.measure(tiny);
    faces.choose_spacing(2, 13);
    std::vector<FacePoints::Point> out;
    faces.sample(folded, vertices, out);
    EXPECT_LT(out.size(), 60000u);
}

/// Points that a fan of n triangles about the origin gets.
std::vector<FacePoints::Point> of_fan(int n, double radius) {
    FacePoints faces;
    std::vector<FacePoints::Point> out;
    const auto at = [&](int i) {
        return radius * Vec3d{std::cos(2 * M_PI * i / n), std::sin(2 * M_PI * i / n), 0};
    };
    const std::vector<std::size_t> vertices{0, 1, 2};
    for (const bool samples : {false, true}) {
        for (int i = 0; i < n; ++i) {
            const std::vector<Vec3d> corners{{}, at(i), at(i + 1)};
            if (samples) faces.sample(corners, vertices, out);
            else faces.measure(corners);
        }
        if (!samples) faces.choose_spacing(2 * radius, 13);
    }
    return out;
}

TEST(FacePoints, LeaveNoHoleInAFanOfSlivers) {
    const std::vector<FacePoints::Point> points = of_fan(96, 1);
    // As many within half of the radius as its share of the area, and some near the middle.
    const auto within = [&](double r) {
        return static_cast<double>(std::count_if(points.begin(), points.end(),
                                                 [&](auto& p) { return length(p.position) < r; }));
    };
    EXPECT_NEAR(within(0.5) / within(2), 0.25, 0.03);
    EXPECT_GT(within(0.1), 0);
}

}  // namespace
}  // namespace slim::test
