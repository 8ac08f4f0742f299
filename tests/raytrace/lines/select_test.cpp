#include "raytrace/lines/select.h"

#include <gtest/gtest.h>

#include <vector>

namespace slim {
namespace {

/// From (x0, y) to (x1, y) in steps of a pixel, a unit of length each; weight so that the strength
/// is as wanted.
FeatureLine level_line(float x0, float x1, float y, float strength, float evidence = 1) {
    FeatureLine line;
    line.kind = LineKind::ridge;
    for (float x = x0; x <= x1; ++x)
        line.points.push_back({x, y, {x, y, 0}, strength / (x1 - x0), evidence});
    return line;
}

constexpr LineRules kRules{0.1f, 0.5f, 1, 0.4f, 4};

TEST(SelectLines, StrengthIsTheIntegralOfTheWeight) {
    FeatureLine line = level_line(0, 10, 3, 2.5f);
    measure_line(line);
    EXPECT_NEAR(line.strength, 2.5f, 1e-5);
    EXPECT_NEAR(line.length, 10, 1e-5);
    EXPECT_NEAR(line.length_px, 10, 1e-5);
}

TEST(SelectLines, WeakLinesStayOnlyWhereTheyContinueStrongOnes) {
    const auto kept = select_lines({level_line(0, 10, 0, 2),       // strong
                                    level_line(12, 20, 1, 0.5f),   // continues it
                                    level_line(22, 30, 1, 0.5f),   // continues that one
                                    level_line(0, 10, 30, 0.5f),   // alone
                                    level_line(32, 40, 1, 0.3f)},  // too weak to continue anything
                                   kRules);
    ASSERT_EQ(kept.size(), 3u);
    for (const FeatureLine& line : kept) EXPECT_LT(line.points[0].y, 2);
}

TEST(SelectLines, ShortOnesAreDroppedHoweverStrong) {
    EXPECT_TRUE(select_lines({level_line(0, 3, 0, 9)}, kRules).empty());
    EXPECT_EQ(select_lines({level_line(0, 5, 0, 9)}, kRules).size(), 1u);
}

TEST(SelectLines, ShortOnesStayWhereTheyContinueOthers) {
    const LineRules rules{0, 0, 0, 0, 8, 2};
    EXPECT_EQ(
        select_lines({level_line(0, 20, 0, 1), level_line(21, 24, 0, 1), level_line(25, 50, 0, 1)},
                     rules)
            .size(),
        3u);
    EXPECT_EQ(select_lines({level_line(0, 20, 0, 1), level_line(41, 44, 0, 1)}, rules).size(), 1u);
}

TEST(SelectLines, ShortOnesThatMeetOthersMidwayWithBothEndsStayWhereTheRulesSaySo) {
    LineRules rules{0, 0, 0, 0, 8, 2};
    const std::vector<FeatureLine> lines{level_line(0, 40, 0, 1), level_line(15, 18, 2, 1),
                                         level_line(20, 23, 3, 1),   // meets the one before too
                                         // meets the end of the first, and no other
                                         level_line(42, 46, 1, 1),
                                         level_line(15, 18, 30, 1)}; // alone
    EXPECT_EQ(select_lines(lines, rules).size(), 2u);
    rules.meets_anywhere = true;
    const auto kept = select_lines(lines, rules);
    ASSERT_EQ(kept.size(), 3u);
    EXPECT_EQ(kept[2].points.front().y, 3);
    EXPECT_TRUE(line_rules(LineKind::contour, 4000, 4000).meets_anywhere);
}

TEST(SelectLines, UnclearOnesAreDroppedHoweverStrong) {
    EXPECT_TRUE(select_lines({level_line(0, 20, 0, 9, 0.3f)}, kRules).empty());
}

TEST(SelectLines, SharpnessIsThatOfTheWholeLine) {
    LineRules rules{0, 0.3f, 1, 0.4f, 4};
    rules.sharpness = 1;
    EXPECT_TRUE(select_lines({level_line(0, 20, 0, 2, 0.4f)}, rules).empty());
    EXPECT_EQ(select_lines({level_line(0, 20, 0, 3, 0.4f)}, rules).size(), 1u);
    EXPECT_EQ(select_lines({level_line(0, 20, 0, 2, 0.6f)}, rules).size(), 1u);
    EXPECT_TRUE(select_lines({level_line(0, 20, 0, 9, 0.2f)}, rules).empty());
    EXPECT_GT(line_rules(LineKind::ridge, 1000, 1000).sharpness, 0);
}

TEST(SelectLines, LinesAreCutWhereTheEvidenceFails) {
    FeatureLine line = level_line(0, 40, 0, 8);
    line.points[20].evidence = 0;
    const auto kept = select_lines({line}, kRules);
    ASSERT_EQ(kept.size(), 2u);
    EXPECT_EQ(kept[0].points.size(), 20u);
    EXPECT_EQ(kept[1].points.size(), 20u);
}

TEST(SelectLines, ALoopIsOpenedOnceWhereItIsCut) {
    FeatureLine line = level_line(0, 40, 0, 8);
    line.closed = true;
    line.points[20].evidence = 0;
    const auto kept = select_lines({line}, kRules);
    ASSERT_EQ(kept.size(), 1u);
    EXPECT_FALSE(kept[0].closed);
    EXPECT_EQ(kept[0].points.size(), 40u);
}

TEST(SmoothLine, KeepsTheEndsAndTakesStepsOut) {
    FeatureLine line = level_line(0, 20, 0, 1);
    for (std::size_t i = 0; i < line.points.size(); ++i) line.points[i].y = i % 2 ? 0.5f : -0.5f;
    const FeatureLine before = line;
    smooth_line(line, 4);
    EXPECT_EQ(line.points.front().y, before.points.front().y);
    EXPECT_EQ(line.points.back().y, before.points.back().y);
    for (std::size_t i = 5; i < 16; ++i) EXPECT_LT(std::abs(line.points[i].y), 0.01f);
}

}  // namespace
}  // namespace slim
