#include "raytrace/lines/label_place.h"

#include "tests/raytrace/lines/relief_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

namespace slim {
namespace {

using test::cone;
using test::ReliefScene;

std::vector<HeightLabel> labels_of(const ReliefScene& s, LabelSheet sheet) {
    return place_height_labels(s.scene(), s.relief, sheet);
}

LabelSheet sheet_of(const ReliefScene& s) { return {s.buffer.width, s.buffer.height, "m", {}}; }

std::set<std::string> texts_of(const std::vector<HeightLabel>& labels) {
    std::set<std::string> texts;
    for (const HeightLabel& label : labels) texts.insert(label.text);
    return texts;
}

TEST(LabelPlace, HeightsOfAHillStandOnItsIndexContoursHeadsUphill) {
    ReliefScene s(1000, 1000, cone(500, 0.5));
    s.relief.spacing = 10, s.relief.base = 0;
    const auto labels = labels_of(s, sheet_of(s));
    EXPECT_EQ(texts_of(labels).count("400 m"), 1u);
    EXPECT_GT(labels.size(), 4u);
    for (const HeightLabel& label : labels) {
        const double height = std::stod(label.text);
        EXPECT_EQ(std::fmod(height, 50), 0) << label.text;
        const double x = static_cast<double>(label.x) - 500, y = static_cast<double>(label.y) - 500;
        EXPECT_NEAR(std::hypot(x, y), 2 * (500 - height), 2.5) << label.text;
        // It is read from below, and its head points to the top of the hill.
        const double up_x = std::sin(label.angle_rad), up_y = -std::cos(label.angle_rad);
        EXPECT_GT(std::cos(label.angle_rad), -0.11f) << label.text;
        const double uphill = -(up_x * x + up_y * y) / std::hypot(x, y);
        EXPECT_GT(std::abs(uphill), 0.98) << label.text;
        // Rings that the picture cuts off have corners where only upside down would be uphill.
        if (height > 250) {
            EXPECT_GT(uphill, 0) << label.text;
        }
        EXPECT_EQ(label.cap_height, 12);
    }
}

TEST(LabelPlace, InAHollowHeadsAreUphillTooAtItsUpperSide) {
    ReliefScene s(1000, 1000, [](double x, double y) { return 0.5 * std::hypot(x, y); });
    s.relief.spacing = 10;
    const auto labels = labels_of(s, sheet_of(s));
    EXPECT_GT(labels.size(), 2u);
    for (const HeightLabel& label : labels) {
        const double radius = 2 * std::stod(label.text);
        if (radius < 480) {
            EXPECT_LT(label.y, 500 + 0.12 * radius) << label.text;
        }
    }
}

TEST(LabelPlace, ASlopeThatFallsToTheTopIsReadUprightHeadsDownhill) {
    ReliefScene s(400, 400, [](double, double y) { return 100 - 0.3 * y; });
    s.relief.spacing = 5;
    const auto labels = labels_of(s, sheet_of(s));
    ASSERT_FALSE(labels.empty());
    for (const HeightLabel& label : labels) EXPECT_GT(std::cos(label.angle_rad), 0.99f);
}

TEST(LabelPlace, HeightsAreAbsoluteWithTheDigitsOfTheirSpacing) {
    ReliefScene s(600, 600, [](double, double y) { return 0.02 * y; });
    s.relief.spacing = 0.5, s.relief.base = 1234.25;
    LabelSheet sheet = sheet_of(s);
    const std::set<std::string> expected{"1230.0 m", "1232.5 m", "1235.0 m", "1237.5 m"};
    const auto texts = texts_of(labels_of(s, sheet));
    for (const std::string& text : texts) EXPECT_TRUE(expected.contains(text)) << text;
    EXPECT_TRUE(texts.contains("1235.0 m"));
    sheet.unit.clear();
    EXPECT_TRUE(texts_of(labels_of(s, sheet)).contains("1235.0"));
    s.relief.base = -3, s.relief.spacing = 1;
    EXPECT_TRUE(texts_of(labels_of(s, sheet)).contains("\u22125"));
}

TEST(LabelPlace, ShortLinesAndCrookedOnesHaveNone) {
    // The only ring, of height 5, has a radius of 4.
    ReliefScene small(200, 200,
                      [](double x, double y) { return std::max(1.0, 7 - 0.5 * std::hypot(x, y)); });
    small.relief.spacing = 1;
    EXPECT_TRUE(labels_of(small, sheet_of(small)).empty());
    const auto waves = [](double height) {
        return [=](double x, double y) { return 50 + 0.2 * (y + height * std::sin(x / 3)); };
    };
    ReliefScene crooked(400, 400, waves(6)), straight(400, 400, waves(0.1));
    crooked.relief.spacing = straight.relief.spacing = 2;
    EXPECT_TRUE(labels_of(crooked, sheet_of(crooked)).empty());
    EXPECT_FALSE(labels_of(straight, sheet_of(straight)).empty());
}

TEST(LabelPlace, NoneDanglesAtALinesEnd) {
    // Straight from the picture's left side on for some pixels, then crooked.
    const auto lines = [](double straight_until) {
        return [=](double x, double y) {
            const double past = std::max(0.0, x + 200 - straight_until);
            return 50 + 0.2 * (y + 6 * std::sin(past / 3));
        };
    };
    const auto n_labels = [&](double straight_until) {
        ReliefScene s(400, 400, lines(straight_until));
        s.relief.spacing = 2;
        return labels_of(s, sheet_of(s)).size();
    };
    ReliefScene all(400, 400, lines(400));
    all.relief.spacing = 2;
    const auto labels = labels_of(all, sheet_of(all));
    ASSERT_FALSE(labels.empty());
    const auto shortest = std::min_element(
        labels.begin(), labels.end(), [](const HeightLabel& p, const HeightLabel& q) {
            return p.half_length() < q.half_length();
        });
    const double own = 2 * static_cast<double>(shortest->half_length()),
                 cap = static_cast<double>(shortest->cap_height);
    EXPECT_EQ(n_labels(own + 1.1 * cap), 0u);
    EXPECT_GT(n_labels(own + 4 * cap), 0u);
}

TEST(LabelPlace, SteepSlopesWhoseIndexContoursHaveNoRoomHaveNone) {
    ReliefScene s(400, 400, [](double, double y) { return 0.9 * y; });
    s.relief.spacing = 1;  // 5.6 pixels from one to the next
    EXPECT_TRUE(labels_of(s, sheet_of(s)).empty());
    s.relief.spacing = 1e-9;
    EXPECT_TRUE(labels_of(s, sheet_of(s)).empty());
    s.relief.spacing = 0;
    EXPECT_TRUE(labels_of(s, sheet_of(s)).empty());
}

float gap_between(const HeightLabel& a, const HeightLabel& b) {
    return std::hypot(a.x - b.x, a.y - b.y) - a.half_height() - b.half_height();
}

TEST(LabelPlace, LabelsKeepClearOfEachOtherTheFrameAndLegends) {
    ReliefScene s(1000, 700, [](double x, double y) {
        return 0.1 * y + 12 * std::sin(x / 90) * std::cos(y / 70);
    });
    s.relief.spacing = 1;
    LabelSheet sheet = sheet_of(s);
    const auto all = labels_of(s, sheet);
    ASSERT_GT(all.size(), 8u);
    for (std::size_t i = 0; i < all.size(); ++i) {
        EXPECT_GT(std::min({all[i].x, all[i].y, 1000 - all[i].x, 700 - all[i].y}), 12);
        for (std::size_t k = 0; k < i; ++k) EXPECT_GT(gap_between(all[i], all[k]), 0);
    }
    sheet.taken = {{0, 0, 1000, 350}};
    const auto lower = labels_of(s, sheet);
    EXPECT_FALSE(lower.empty());
    for (const HeightLabel& label : lower) EXPECT_GT(label.y, 350);
}

TEST(LabelPlace, ASmallerFrameOfTheViewPutsThemAtTheSamePlaces) {
    const auto hill = [](double x, double y) { return 300 - 0.2 * x - 0.4 * y; };
    ReliefScene whole(1200, 900, hill), small(600, 450, hill, 2);
    whole.relief.spacing = small.relief.spacing = 10;
    const LabelSheet sheet{1200, 900, "m", {}};
    const auto a = labels_of(whole, sheet), b = labels_of(small, sheet);
    ASSERT_EQ(a.size(), b.size());
    ASSERT_FALSE(a.empty());
    for (std::size_t i = 0; i < a.size(); ++i) {
        const auto same = std::find_if(b.begin(), b.end(), [&](const HeightLabel& l) {
            return l.text == a[i].text && std::hypot(l.x - a[i].x, l.y - a[i].y) < 12;
        });
        EXPECT_NE(same, b.end()) << a[i].text;
    }
}

TEST(LabelPlace, NothingIsWrittenBesideTheSurface) {
    ReliefScene s(400, 400, [](double x, double y) {
        return std::abs(x) > 30 ? std::nan("") : 0.2 * y;  // too narrow for a label
    });
    s.relief.spacing = 2;
    EXPECT_TRUE(labels_of(s, sheet_of(s)).empty());
}

}  // namespace
}  // namespace slim
