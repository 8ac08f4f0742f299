#include "raytrace/lines/tidy.h"

#include "raytrace/lines/join.h"
#include "raytrace/lines/select.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace slim {
namespace {

/// From (x0, y) to (x1, y) in steps of a pixel, a unit of length each, at that depth.
FeatureLine level_line(float x0, float x1, float y, float depth = 0) {
    FeatureLine line;
    for (float x = x0; x <= x1; ++x) line.points.push_back({x, y, {x, y, depth}, 1, 1});
    return line;
}

/// Part of a circle about (50, 50), angles in degrees.
FeatureLine arc(double radius, int from, int to) {
    FeatureLine line;
    for (int a = from; a <= to; ++a) {
        const double t = a * std::numbers::pi / 180;
        const auto x = static_cast<float>(50 + radius * std::cos(t)),
                   y = static_cast<float>(50 + radius * std::sin(t));
        line.points.push_back({x, y, {x, y, 0}, 1, 1});
    }
    return line;
}

float total_px(std::vector<FeatureLine> lines) {
    float px = 0;
    for (FeatureLine& line : lines) measure_line(line), px += line.length_px;
    return px;
}

TEST(TidyContours, WhatRunsBesideALongerLineIsLeftToIt) {
    const auto one = tidy_contours({level_line(20, 50, 1), level_line(0, 80, 0)}, 1);
    ASSERT_EQ(one.size(), 1u);
    EXPECT_EQ(one[0].points.size(), 81u);
    // Two pixels away is another line.
    EXPECT_EQ(tidy_contours({level_line(20, 50, 2), level_line(0, 80, 0)}, 1).size(), 2u);
    // A pixel of a picture 2000 high is half as large.
    EXPECT_EQ(tidy_contours({level_line(20, 50, 2), level_line(0, 80, 0)}, 2).size(), 1u);
}

TEST(TidyContours, ABranchKeepsWhatLeavesTheLine) {
    FeatureLine branch = level_line(20, 40, 1);
    for (float y = 2; y <= 30; ++y) branch.points.push_back({40 + y, y, {40 + y, y, 0}, 1, 1});
    const auto lines = tidy_contours({branch, level_line(0, 80, 0)}, 1);
    ASSERT_EQ(lines.size(), 2u);
    EXPECT_NEAR(total_px({lines[1]}), 29 * std::numbers::sqrt2, 3);
    EXPECT_LT(lines[1].points[0].y, 1.6f);  // begins at the line
}

TEST(TidyContours, LinesThatCrossStayWhole) {
    FeatureLine across;
    for (float y = -20; y <= 20; ++y) across.points.push_back({40, y, {40, y, 0}, 1, 1});
    const auto lines = tidy_contours({across, level_line(0, 80, 0)}, 1);
    ASSERT_EQ(lines.size(), 2u);
    EXPECT_FLOAT_EQ(total_px(lines), 120);
}

TEST(TidyContours, UnclearEndsGoAndShortUnclearPartsStay) {
    FeatureLine line = level_line(0, 80, 0);
    for (std::size_t i = 60; i <= 80; ++i) line.points[i].evidence = 0.1f;
    for (std::size_t i = 30; i < 36; ++i) line.points[i].evidence = 0.1f;
    auto lines = tidy_contours({line}, 1);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_EQ(lines[0].points.front().x, 0);
    EXPECT_EQ(lines[0].points.back().x, 59);
    for (std::size_t i = 30; i < 50; ++i) line.points[i].evidence = 0.1f;
    EXPECT_EQ(tidy_contours({line}, 1).size(), 2u);
    for (LinePoint& p : line.points) p.evidence = 0.4f;
    EXPECT_TRUE(tidy_contours({line}, 1).empty());
}

TEST(TidyContours, AnUnclearPartOpensALoopOnce) {
    FeatureLine ring = arc(40, 0, 359);
    ring.closed = true;
    EXPECT_TRUE(tidy_contours({ring}, 1)[0].closed);
    for (std::size_t i = 100; i < 150; ++i) ring.points[i].evidence = 0;
    const auto lines = tidy_contours({ring}, 1);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_FALSE(lines[0].closed);
    EXPECT_EQ(lines[0].points.size(), 310u);
}

TEST(TidyContours, AnUnclearPartAtALoopsSeamIsOne) {
    FeatureLine ring = arc(40, 0, 359);  // 0.7 pixels a point
    ring.closed = true;
    for (std::size_t i = 0; i < 12; ++i)
        ring.points[i].evidence = ring.points[359 - i].evidence = 0;
    const auto lines = tidy_contours({ring}, 1);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_FALSE(lines[0].closed);
    EXPECT_EQ(lines[0].points.size(), 360u - 24);
}

TEST(JoinEnds, EndsThatMeetAreOneLineHoweverTheyRun) {
    FeatureLine back = level_line(43, 80, 0);
    std::reverse(back.points.begin(), back.points.end());
    const auto lines = join_ends({level_line(0, 40, 0), back, level_line(85, 90, 1)}, 1);
    ASSERT_EQ(lines.size(), 1u);
    for (std::size_t i = 1; i < lines[0].points.size(); ++i)
        EXPECT_GT(lines[0].points[i].x, lines[0].points[i - 1].x);
    EXPECT_EQ(lines[0].points.size(), 41u + 38 + 6);
}

TEST(JoinEnds, NotOverAGapInSpaceOrASharpTurn) {
    EXPECT_EQ(join_ends({level_line(0, 40, 0), level_line(42, 80, 0, 100)}, 1).size(), 2u);
    // beside each other
    EXPECT_EQ(join_ends({level_line(0, 40, 0), level_line(0, 40, 3)}, 1).size(), 2u);
    // 8 pixels away
    EXPECT_EQ(join_ends({level_line(0, 40, 0), level_line(48, 80, 0)}, 1).size(), 2u);
}

TEST(JoinEnds, ArcsOfACircleAreALoop) {
    const auto lines = join_ends({arc(40, 181, 359), arc(40, 1, 178)}, 1);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_TRUE(lines[0].closed);
    EXPECT_NEAR(total_px(lines), 2 * std::numbers::pi * 40, 0.5);
}

}  // namespace
}  // namespace slim
