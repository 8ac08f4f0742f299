#include "raytrace/lines/one_stroke.h"

#include "raytrace/lines/select.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace slim {
namespace {

constexpr float kTurned = -0.3f, kSeen = 0.6f;  ///< N.v of the face that is turned away most

LinePoint point_at(LineKind kind, float x, float y, float facing, float depth) {
    return {x, y, {x, y, depth}, is_crease(kind) ? 0.0f : 1.0f, is_crease(kind) ? 90.0f : 1.0f,
            facing};
}

/// From (x0, y0) to (x1, y1) in steps of at most a pixel, a unit of length each, at that depth.
FeatureLine line_to(LineKind kind, float x0, float y0, float x1, float y1, float facing = 1,
                    float depth = 0) {
    FeatureLine line;
    line.kind = kind;
    const int n = static_cast<int>(std::ceil(std::hypot(x1 - x0, y1 - y0)));
    for (int i = 0; i <= n; ++i) {
        const float u = static_cast<float>(i) / static_cast<float>(n);
        const float x = x0 + u * (x1 - x0), y = y0 + u * (y1 - y0);
        line.points.push_back(point_at(kind, x, y, facing, depth));
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

constexpr float kRadius = 100, kTurn = 6.2831853f;
/// About (0, 0), by angles, in steps of about a pixel, a unit of length each.
FeatureLine arc(LineKind kind, float radius, float from, float to, float facing = 1,
                float depth = 0) {
    FeatureLine line;
    line.kind = kind;
    line.closed = to - from >= kTurn;
    const int n = static_cast<int>(std::ceil((to - from) * radius));
    for (int i = 0; i < n + (line.closed ? 0 : 1); ++i) {
        const float a = from + (to - from) * static_cast<float>(i) / static_cast<float>(n);
        line.points.push_back(
            point_at(kind, radius * std::cos(a), radius * std::sin(a), facing, depth));
    }
    measure_line(line);
    return line;
}
/// From 0 to a whole turn.
float angle_of(const LinePoint& p) {
    const float a = std::atan2(p.y, p.x);
    return a < 0 ? a + kTurn : a;
}

std::vector<FeatureLine> of_kind(const std::vector<FeatureLine>& lines, LineKind kind) {
    std::vector<FeatureLine> out;
    for (const FeatureLine& line : lines)
        if (line.kind == kind) out.push_back(line);
    return out;
}

/// Of all lines, in space.
float longest_step(const std::vector<FeatureLine>& lines) {
    float longest = 0;
    for (const FeatureLine& line : lines)
        line.for_each_segment([&](const LinePoint& a, const LinePoint& b) {
            longest = std::max(longest, length(b.point - a.point));
        });
    return longest;
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

TEST(OneStroke, WhatLeavesALineOfAnotherDepthStaysOnItsOwnSurface) {
    for (const LineKind kind : {LineKind::ridge, LineKind::valley, LineKind::suggestive,
                                LineKind::convex_crease}) {
        const FeatureLine whole = line_to(kind, -40, 2, 80, 2, kSeen, 500);
        const auto rests = of_kind(one_stroke({whole, contour(0, 0, 80, 0)}, 1), kind);
        ASSERT_EQ(rests.size(), 1u);
        EXPECT_EQ(rests[0].points.back().y, 0);  // in the picture it begins at the other
        for (const LinePoint& p : rests[0].points) EXPECT_EQ(p.point.z, 500);
        EXPECT_LE(longest_step(rests), 1.001f);
        EXPECT_NEAR(rests[0].length, 40, 2);
        EXPECT_NEAR(rests[0].strength, is_crease(kind) ? 90 : 40, 2);
    }
}

TEST(OneStroke, WhatYieldsGrowsNoLongerInSpace) {
    // The two are 10 apart, as along a wall that is seen nearly edge-on.
    const FeatureLine ridge = line_to(LineKind::ridge, -40, 2, 80, 2, 1, 10);
    const auto lines = one_stroke({ridge, contour(0, 0, 80, 0)}, 1);
    ASSERT_EQ(lines.size(), 2u);
    EXPECT_NEAR(lines[0].length, 40, 2);
    EXPECT_FLOAT_EQ(lines[0].strength, lines[0].length);
    EXPECT_LE(longest_step(lines), 1.001f);
}

TEST(OneStroke, OutlinesNearTheCreaseThatTheyGoOnAsInSpaceByAndBy) {
    // The contour's points lie 15 before the crease's, as those of a limb may.
    FeatureLine branch = contour(0, 2, 40, 2, 15);
    const FeatureLine on = contour(41, 3, 80, 42, 15);
    branch.points.insert(branch.points.end(), on.points.begin(), on.points.end());
    measure_line(branch);
    for (const float facing : {kTurned, kSeen}) {
        const FeatureLine edge = crease(0, 0, 80, 0, facing);
        const auto lines = one_stroke({edge, branch}, 1);
        ASSERT_EQ(lines.size(), 2u);
        EXPECT_EQ(lines[1].points[0].point.z * lines[1].points.back().point.z, 0);
        EXPECT_LT(longest_step(lines), 3.5f);
        EXPECT_LT(lines[1].length, lines[1].length_px + 10);
        // Far from the crease it is where it was.
        EXPECT_EQ(std::max(lines[1].points[0].point.z, lines[1].points.back().point.z), 15);
    }
}

TEST(OneStroke, OutlinesTakeNoPointsOfAnotherDepth) {
    // Where the contour leaves its crease another, far behind, is nearer in the picture.
    FeatureLine outline = contour(0, 1.2f, 80, 1.2f);
    const FeatureLine on = contour(81, 1.2f, 140, -40);
    outline.points.insert(outline.points.end(), on.points.begin(), on.points.end());
    measure_line(outline);
    for (const float facing : {kTurned, kSeen}) {
        const auto lines =
            one_stroke({crease(0, 0, 80, 0, facing),
                        line_to(LineKind::convex_crease, 70, 2, 90, 2, facing, 900), outline},
                       1);
        const auto contours = of_kind(lines, LineKind::contour);
        ASSERT_EQ(contours.size(), 1u);
        EXPECT_LT(longest_step(lines), 2.5f);
        EXPECT_LT(contours[0].length, outline.length + 2);
    }
}

TEST(OneStroke, AnEndMeetsTheOutlineThatItGoesOnAsNotANearerOneBehind) {
    FeatureLine branch = contour(0, 1, 40, 1);
    const FeatureLine on = contour(41, 1, 80, 40);
    branch.points.insert(branch.points.end(), on.points.begin(), on.points.end());
    measure_line(branch);
    // Ends of outlines far behind, at every place where the contour may leave the crease.
    std::vector<FeatureLine> lines{crease(0, 0, 80, 0, kTurned), branch};
    for (float x = 38; x < 46; x += 0.5f)
        for (const LineKind kind : {LineKind::concave_crease, LineKind::contour})
            lines.push_back(line_to(kind, x, 0.2f, x - 30, -60, kTurned, 900));
    EXPECT_LT(longest_step(one_stroke(lines, 1)), 4);
}

TEST(OneStroke, ARingThatIsPartlySharedIsCutThereOnly) {
    for (const float brief : {0.01f, 0.03f, 0.05f}) {
        const auto rests = of_kind(
            one_stroke({arc(LineKind::ridge, kRadius, 0, kTurn),
                        arc(LineKind::contour, kRadius + 2, 1, 1 + brief),
                        arc(LineKind::contour, kRadius + 2, 3, 3.6f)},
                       1),
            LineKind::ridge);
        ASSERT_EQ(rests.size(), 1u) << brief;
        EXPECT_FALSE(rests[0].closed);
        EXPECT_NEAR(rests[0].length_px, (kTurn - 0.6f) * kRadius, 8);
        EXPECT_NEAR(angle_of(rests[0].points.front()), 3.6f, 0.05f);
        EXPECT_NEAR(angle_of(rests[0].points.back()), 3, 0.05f);
    }
    // Shared for a few pixels only, all along, and nowhere.
    const FeatureLine ring = arc(LineKind::ridge, kRadius, 0, kTurn);
    const auto whole =
        one_stroke({ring, arc(LineKind::contour, kRadius + 2, 1, 1.03f)}, 1);
    ASSERT_EQ(whole.size(), 2u);
    EXPECT_TRUE(whole[0].closed);
    EXPECT_EQ(whole[0].points.size(), ring.points.size());
    EXPECT_EQ(one_stroke({ring, arc(LineKind::contour, kRadius + 2, 0, kTurn)}, 1).size(), 1u);
    EXPECT_TRUE(one_stroke({ring, arc(LineKind::contour, kRadius + 9, 0, kTurn)}, 1)[0].closed);
}

TEST(OneStroke, ARimHalfOfWhichIsOutlineIsTwoLines) {
    for (const float from : {0.5f, 2.0f, 3.7f}) {
        FeatureLine rim = arc(LineKind::convex_crease, kRadius, 0, kTurn, kSeen);
        for (LinePoint& p : rim.points)
            if (angle_of(p) > from && angle_of(p) < from + 2) p.facing = kTurned;
        for (const FeatureLine& other :
             {arc(LineKind::contour, kRadius + 1, 0, kTurn),
              arc(LineKind::contour, kRadius + 1, from - 0.4f, from + 2.4f)}) {
            const auto lines = one_stroke({rim, other}, 1);
            ASSERT_EQ(lines.size(), 2u) << from;
            EXPECT_EQ(lines[0].kind, LineKind::convex_crease);
            EXPECT_NEAR(lines[0].length_px, (kTurn - 2) * kRadius, 3);
            EXPECT_NEAR(angle_of(lines[0].points.front()), from + 2, 0.02f);
            EXPECT_EQ(lines[1].kind, LineKind::contour);
            EXPECT_NEAR(lines[1].length_px, 2 * kRadius, 3);
        }
    }
}

TEST(OneStroke, ACrumbAtTheSeamOfARingGoesAsAnyOther) {
    // Two creases of less than 6 pixels each and what crosses between them.
    for (const float at : {0.0f, 1.0f}) {
        FeatureLine crossing;
        crossing.kind = LineKind::concave_crease;
        for (float r = kRadius - 10; r < kRadius + 10; ++r)
            crossing.points.push_back(
                point_at(crossing.kind, r * std::cos(at), r * std::sin(at), kSeen, 0));
        measure_line(crossing);
        const auto lines = of_kind(
            one_stroke({arc(LineKind::contour, kRadius, 0, kTurn), crossing,
                        arc(LineKind::convex_crease, kRadius, at - 0.05f, at - 0.02f, kSeen),
                        arc(LineKind::convex_crease, kRadius, at + 0.02f, at + 0.05f, kSeen)},
                       1),
            LineKind::contour);
        ASSERT_EQ(lines.size(), 1u) << at;
        EXPECT_FALSE(lines[0].closed) << at;
        EXPECT_NEAR(lines[0].length_px, (kTurn - 0.1f) * kRadius, 3);
    }
}

TEST(OneStroke, ACreaseThatIsOutlineInItsMiddleIsThreeLinesThatMeet) {
    FeatureLine edge = crease(0, 0, 80, 0, kSeen);
    for (LinePoint& p : edge.points)
        if (p.x > 30 && p.x < 60) p.facing = kTurned;
    const auto lines = one_stroke({edge, contour(0, 1.2f, 80, 1.2f)}, 1);
    const auto creases = of_kind(lines, LineKind::convex_crease),
               contours = of_kind(lines, LineKind::contour);
    ASSERT_EQ(creases.size(), 2u);
    ASSERT_EQ(contours.size(), 1u);
    EXPECT_FLOAT_EQ(creases[0].length_px + creases[1].length_px + contours[0].length_px, 80);
    EXPECT_EQ(creases[0].points.back().x, contours[0].points.front().x);
    EXPECT_EQ(contours[0].points.back().x, creases[1].points.front().x);
    EXPECT_NEAR(contours[0].length_px, 30, 1);
    EXPECT_FLOAT_EQ(contours[0].strength, contours[0].length_px);
    EXPECT_FLOAT_EQ(creases[0].strength, 90);
}

TEST(OneStroke, BriefPartsThatJustFaceTheEyeDoNotCutAnOutline) {
    for (const float facing : {kTurned, kSeen}) {  // and brief parts that just do not cut a crease
        FeatureLine edge = crease(0, 0, 80, 0, facing);
        for (LinePoint& p : edge.points)
            if (static_cast<int>(p.x) % 20 >= 16) p.facing = facing == kTurned ? 0.15f : 0.05f;
        edge.points.back().facing = facing;
        const auto lines = one_stroke({edge, contour(0, 1.2f, 80, 1.2f)}, 1);
        ASSERT_EQ(lines.size(), 1u);
        EXPECT_EQ(lines[0].kind,
                  facing == kTurned ? LineKind::contour : LineKind::convex_crease);
        EXPECT_FLOAT_EQ(lines[0].length_px, 80);
    }
}

TEST(OneStroke, LinesOfNoneOrOnePointAreLeftOut) {
    std::vector<FeatureLine> lines{crease(0, 0, 80, 0, kSeen), contour(0, 1.2f, 80, 1.2f)};
    for (const LineKind kind : kAllLineKinds)
        for (const bool closed : {false, true})
            for (const std::size_t n : {0u, 1u}) {
                FeatureLine line = line_to(kind, 40, 1, 41, 1);
                line.points.resize(n), line.closed = closed;
                lines.push_back(line);
            }
    const auto kept = one_stroke(lines, 1);
    ASSERT_EQ(kept.size(), 1u);
    EXPECT_FLOAT_EQ(kept[0].length_px, 80);
    EXPECT_TRUE(one_stroke({}, 1).empty());
    EXPECT_TRUE(one_stroke({FeatureLine{}}, 1).empty());
}

}  // namespace
}  // namespace slim
