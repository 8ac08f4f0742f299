#include "raytrace/lines/short_lines.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace slim {
namespace {

/// From one place to another in steps of a pixel, a unit of length each.
FeatureLine straight(float x0, float y0, float x1, float y1) {
    FeatureLine line;
    const float px = std::hypot(x1 - x0, y1 - y0);
    for (float s = 0; s <= px; ++s) {
        const float x = x0 + (x1 - x0) * s / px, y = y0 + (y1 - y0) * s / px;
        line.points.push_back({x, y, {x, y, 0}, 1, 1});
    }
    return line;
}

/// About (50, 50).
FeatureLine circle(float radius) {
    FeatureLine line;
    line.closed = true;
    for (int a = 0; a < 360; a += 10) {
        const float t = static_cast<float>(a) * std::numbers::pi_v<float> / 180,
                    x = 50 + radius * std::cos(t), y = 50 + radius * std::sin(t);
        line.points.push_back({x, y, {x, y, 0}, 1, 1});
    }
    return line;
}

std::vector<FeatureLine> linked(std::vector<FeatureLine> lines, bool meets_anywhere = true) {
    LineRules rules;
    rules.least_px = 10, rules.meets_anywhere = meets_anywhere;
    return link_short_lines(std::move(lines), rules, 1);
}

TEST(LinkShortLines, WhatContinuesALineBecomesPartOfIt) {
    // 2.8 pixels on, and off to a side; then across a gap to the next long one.
    const auto one =
        linked({straight(0, 0, 40, 0), straight(42, 2, 47, 3), straight(50, 4, 90, 4)});
    ASSERT_EQ(one.size(), 1u);
    EXPECT_NEAR(one[0].length_px, 90, 2);
}

TEST(LinkShortLines, BesideOneLineAShortOneShowsNothing) {
    EXPECT_EQ(linked({straight(0, 0, 80, 0), straight(20, 2, 28, 2)}).size(), 1u);
    // and where two lines meet anyway
    EXPECT_EQ(
        linked({straight(0, 0, 80, 0), straight(40, 1, 40, 60), straight(38, 2, 41, 2)}).size(),
        2u);
}

TEST(LinkShortLines, ABridgeStays) {
    // between two lines, midway, and between the legs of one that comes back
    EXPECT_EQ(linked({straight(0, 0, 80, 0), straight(0, 8, 80, 8), straight(40, 1, 40, 7)}).size(),
              3u);
    FeatureLine bow = straight(0, 0, 60, 0);
    for (const FeatureLine& leg : {straight(60, 1, 60, 7), straight(60, 8, 0, 8)})
        bow.points.insert(bow.points.end(), leg.points.begin(), leg.points.end());
    EXPECT_EQ(linked({bow, straight(10, 1, 10, 7)}).size(), 2u);
    // of lines whose ends alone may meet others there are none
    EXPECT_EQ(linked({bow, straight(10, 1, 10, 7)}, false).size(), 1u);
}

TEST(LinkShortLines, TheOutlineOfASmallPartStays) {
    const auto kept = linked({circle(1.6f), straight(10, 10, 16, 10)});
    ASSERT_EQ(kept.size(), 1u);
    EXPECT_TRUE(kept[0].closed);
    // that of a step which is one for 6 pixels, and less than one wide, does not
    FeatureLine sliver = straight(0, 0, 6, 0.4f);
    for (const LinePoint& p : straight(6, 0.8f, 0, 0.8f).points) sliver.points.push_back(p);
    sliver.closed = true;
    EXPECT_TRUE(linked({sliver}).empty());
}

TEST(LinkShortLines, SmallLoopsOfAKindThatRulesThemOutStayIfStrong) {
    LineRules rules;
    rules.least_px = 10, rules.loop_px = 64, rules.loop_strength = 70;
    const auto n_kept = [&](const FeatureLine& line) {
        return link_short_lines({line}, rules, 1).size();
    };
    FeatureLine strong = circle(8);  // 50 pixels
    for (LinePoint& p : strong.points) p.weight = 2;
    EXPECT_EQ(n_kept(circle(8)), 0u);
    EXPECT_EQ(n_kept(strong), 1u);
    EXPECT_EQ(n_kept(circle(11)), 1u);
    EXPECT_EQ(n_kept(straight(0, 0, 40, 0)), 1u);
    // also one that ends which meet close
    FeatureLine open = circle(8);
    open.closed = false;
    EXPECT_EQ(n_kept(open), 0u);
    rules = line_rules(LineKind::suggestive, 1000, 800);
    EXPECT_GT(rules.loop_px, rules.least_px);
}

}  // namespace
}  // namespace slim
