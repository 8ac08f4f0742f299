#include "raytrace/lines/one_stroke.h"

#include "raytrace/lines/select.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

namespace slim {
namespace {

constexpr float kTurned = -0.3f, kSeen = 0.6f;  ///< N.v of the face that is turned away most

/// From (x0, y0) to (x1, y1) in steps of at most a pixel, a unit of length each, at that depth.
FeatureLine line_to(LineKind kind, float x0, float y0, float x1, float y1, float facing = 1,
                    float depth = 0) {
    FeatureLine line;
    line.kind = kind;
    const int n = static_cast<int>(std::ceil(std::hypot(x1 - x0, y1 - y0)));
    for (int i = 0; i <= n; ++i) {
        const float u = static_cast<float>(i) / static_cast<float>(n);
        const float x = x0 + u * (x1 - x0), y = y0 + u * (y1 - y0);
        line.points.push_back({x, y, {x, y, depth}, is_crease(kind) ? 0.0f : 1.0f,
                               is_crease(kind) ? 90.0f : 1.0f, facing});
    }
    measure_line(line);
    return line;
}
FeatureLine contour(float x0, float y0, float x1, float y1, float depth = 0) {
    return line_to(LineKind::contour, x0, y0, x1, y1, 1, depth);
}
FeatureLine crease(float x0, float y0, float x1, float y1, float facing) {
    return line_to(LineKind::convex_crease, x0, y0, x1, y1, facing);
}

float px_of(const std::vector<FeatureLine>& lines, LineKind kind) {
    float px = 0;
    for (const FeatureLine& line : lines) px += line.kind == kind ? line.length_px : 0;
    return px;
}

TEST(OneStroke, AnOutlineAlongACreaseIsOneContourWhereTheCreaseIs) {
    const auto lines = one_stroke({crease(0, 0, 80, 0, kTurned), contour(0, 1.2f, 80, 1.2f)}, 1);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_EQ(lines[0].kind, LineKind::contour);
    EXPECT_FLOAT_EQ(lines[0].length_px, 80);
    EXPECT_FLOAT_EQ(lines[0].strength, 80);  // as of contours
    for (const LinePoint& p : lines[0].points) EXPECT_EQ(p.y, 0);
}

TEST(OneStroke, BetweenTwoFacesThatAreSeenTheCreaseStays) {
    const auto lines = one_stroke({crease(0, 0, 80, 0, kSeen), contour(0, 1.2f, 80, 1.2f)}, 1);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_EQ(lines[0].kind, LineKind::convex_crease);
    EXPECT_FLOAT_EQ(lines[0].length_px, 80);
}

TEST(OneStroke, WhatEndsInNearlyTheSameLineOfSightIsTheContour) {
    for (const float facing : {kTurned, kSeen}) {
        const auto lines =
            one_stroke({crease(0, 0, 80, 0, facing), contour(0, 1.2f, 80, 1.2f, 500)}, 1);
        ASSERT_EQ(lines.size(), 1u);
        EXPECT_EQ(lines[0].kind, LineKind::contour);
        EXPECT_EQ(lines[0].points[3].y, 1.2f);
    }
}

TEST(OneStroke, LinesThatDifferStay) {
    for (const FeatureLine& other :
         {contour(0, 3, 80, 3), contour(40, -40, 40, 40), contour(10, -2, 70, 38),
          contour(81.5f, 0, 150, 0)}) {
        const auto lines = one_stroke({crease(0, 0, 80, 0, kTurned), other}, 1);
        EXPECT_FLOAT_EQ(px_of(lines, LineKind::convex_crease), 80);
        EXPECT_FLOAT_EQ(px_of(lines, LineKind::contour), other.length_px);
    }
    // A pixel of a picture 2000 high is half as large.
    EXPECT_EQ(one_stroke({crease(0, 0, 80, 0, kTurned), contour(0, 3, 80, 3)}, 2).size(), 1u);
}

TEST(OneStroke, WhatLeavesTheOtherLineBeginsAtIt) {
    FeatureLine branch = contour(0, 1, 40, 1);
    const FeatureLine on = contour(41, 2, 80, 41);
    branch.points.insert(branch.points.end(), on.points.begin(), on.points.end());
    measure_line(branch);
    // The outline goes on where it leaves the crease, whose rest is one of its own.
    const auto outline = one_stroke({crease(0, 0, 80, 0, kTurned), branch}, 1);
    ASSERT_EQ(outline.size(), 2u);
    EXPECT_EQ(outline[0].kind, LineKind::convex_crease);
    EXPECT_NEAR(outline[0].points[0].x, 41, 3);
    EXPECT_EQ(outline[1].kind, LineKind::contour);
    EXPECT_NEAR(outline[1].length_px, 40 + 40 * std::sqrt(2.0f), 3);
    EXPECT_EQ(outline[1].points.front().x + outline[1].points.back().x, 80);
    for (std::size_t i = 1; i < outline[1].points.size(); ++i) {
        const LinePoint &a = outline[1].points[i - 1], &b = outline[1].points[i];
        EXPECT_LE(std::hypot(b.x - a.x, b.y - a.y), 3);
    }
    const auto inner = one_stroke({crease(0, 0, 80, 0, kSeen), branch}, 1);
    ASSERT_EQ(inner.size(), 2u);
    EXPECT_FLOAT_EQ(inner[0].length_px, 80);
    EXPECT_EQ(inner[1].points[0].y, 0);
    EXPECT_NEAR(inner[1].length_px, 40 * std::sqrt(2.0f), 5);
}

TEST(OneStroke, OutlinesHaveTheCreasesCorners) {
    // A square whose corners the contour has cut.
    FeatureLine ring;
    for (const FeatureLine& side :
         {contour(2, 1, 98, 1), contour(99, 2, 99, 98), contour(98, 99, 2, 99),
          contour(1, 98, 1, 2)})
        ring.points.insert(ring.points.end(), side.points.begin(), side.points.end());
    ring.closed = true;
    measure_line(ring);
    const auto lines = one_stroke({crease(0, 0, 100, 0, kTurned), crease(100, 0, 100, 100, kTurned),
                                   crease(0, 100, 100, 100, kTurned),
                                   crease(0, 0, 0, 100, kTurned), ring},
                                  1);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_EQ(lines[0].kind, LineKind::contour);
    EXPECT_TRUE(lines[0].closed);
    EXPECT_FLOAT_EQ(lines[0].length_px, 400);
}

TEST(OneStroke, BridgesStay) {
    // The contour is open for 7 pixels, where the crease goes on.
    const auto lines = one_stroke({crease(0, 0, 80, 0, kSeen), contour(0, 1.2f, 37, 1.2f, 500),
                                   contour(44, 1.2f, 80, 1.2f, 500)},
                                  1);
    EXPECT_NEAR(px_of(lines, LineKind::convex_crease), 7, 3);
    EXPECT_FLOAT_EQ(px_of(lines, LineKind::contour), 37 + 36);
}

TEST(OneStroke, CrestLinesAndSuggestiveContoursGoBesideContours) {
    for (const LineKind kind : {LineKind::ridge, LineKind::valley, LineKind::suggestive}) {
        const auto lines = one_stroke({line_to(kind, -40, 2, 80, 2), contour(0, 0, 80, 0)}, 1);
        ASSERT_EQ(lines.size(), 2u);
        EXPECT_EQ(lines[0].kind, kind);  // the order of kinds is as it was
        EXPECT_NEAR(lines[0].length_px, 40, 4);
        EXPECT_EQ(lines[0].points.back().y, 0);
    }
    for (const LineKind kind : {LineKind::parabolic, LineKind::reflection})
        EXPECT_EQ(one_stroke({line_to(kind, 0, 2, 80, 2), contour(0, 0, 80, 0)}, 1).size(), 2u);
    EXPECT_EQ(one_stroke({line_to(LineKind::ridge, 0, 2, 80, 2),
                          line_to(LineKind::valley, 0, 0, 80, 0)},
                         1)
                  .size(),
              2u);
}

}  // namespace
}  // namespace slim
