#include "raytrace/lines/height_line.h"

#include "raytrace/crop.h"
#include "tests/raytrace/lines/relief_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace slim {
namespace {

using test::cone;
using test::ReliefScene;

std::vector<HeightLine> lines_of(const ReliefScene& s, double spacing) {
    HeightLineSearch search(s.relief, spacing);
    search.add(s.scene(), 0);
    return search.finish().value();
}

TEST(HeightLine, OfAConeAreItsCircles) {
    const ReliefScene s(200, 160, cone(100.7, 0.5));
    const auto lines = lines_of(s, 10);
    // Heights 100 to 70 are rings of radius 2 (100.7 - h) below 80.
    int rings = 0;
    for (const HeightLine& line : lines) {
        const double radius = 2 * (100.7 - 10 * static_cast<double>(line.level));
        for (const PicturePoint& p : line.points)
            EXPECT_NEAR(std::hypot(p.x - 100, p.y - 80), radius, 0.35) << line.level;
        rings += line.closed;
        if (line.closed) {
            EXPECT_GT(static_cast<double>(line.points.size()), 4 * radius);
        }
    }
    EXPECT_EQ(rings, 4);
    EXPECT_TRUE(std::is_sorted(lines.begin(), lines.end(), [](const auto& a, const auto& b) {
        return a.level < b.level;
    }));
}

TEST(HeightLine, CountsHeightsFromTheWorldsZero) {
    ReliefScene s(60, 60, cone(3, 0.2));
    s.relief.base = 1000;
    const auto lines = lines_of(s, 1);
    ASSERT_FALSE(lines.empty());
    EXPECT_EQ(lines.back().level, 1002);
}

TEST(HeightLine, OfMorePiecesThanAllowedThereIsNone) {
    const ReliefScene s(60, 60, [](double x, double) { return x / 10; });
    // Heights -2.95 to 2.95: 5 lines of 59 pieces.
    HeightLineSearch enough(s.relief, 1, 295), few(s.relief, 1, 294);
    enough.add(s.scene(), 0), few.add(s.scene(), 0);
    EXPECT_EQ(enough.finish().value().size(), 5u);
    EXPECT_FALSE(few.finish());
    few.add(s.scene(), 0);  // nor of what comes then
    EXPECT_FALSE(few.finish());
}

TEST(HeightLine, BandsMakeThoseOfTheWhole) {
    const ReliefScene s(90, 70, [](double x, double y) {
        return 5 * std::sin(x / 7) * std::cos(y / 9) + 0.1 * x;
    });
    const auto whole = lines_of(s, 1);
    EXPECT_GT(whole.size(), 20u);
    HeightLineSearch search(s.relief, 1);
    for (const auto& [top, begin, end] : {std::array{0, 0, 31}, {25, 31, 32}, {20, 32, 70}}) {
        // Planes from row `top` on, one row more than is searched.
        const int bottom = std::min(70, end + 1);
        ReliefScene band = s;
        band.buffer = crop(s.buffer, {0, top, 90, bottom - top});
        search.add(band.scene({top, 70, begin - top, end - top}), 0);
    }
    const auto banded = search.finish().value();
    ASSERT_EQ(banded.size(), whole.size());
    for (std::size_t i = 0; i < whole.size(); ++i) {
        EXPECT_EQ(banded[i].level, whole[i].level);
        EXPECT_EQ(banded[i].closed, whole[i].closed);
        ASSERT_EQ(banded[i].points.size(), whole[i].points.size());
        for (std::size_t k = 0; k < whole[i].points.size(); ++k)
            EXPECT_TRUE(banded[i].points[k].x == whole[i].points[k].x &&
                        banded[i].points[k].y == whole[i].points[k].y);
    }
}

TEST(HeightLine, AStepOfTheSurfaceHasNone) {
    const ReliefScene s(40, 40, [](double x, double) { return x < 0.3 ? 0.5 : 20.5; });
    EXPECT_TRUE(lines_of(s, 1).empty());
    // A slope between the same heights has all twenty.
    const ReliefScene slope(40, 40, [](double x, double) { return 10.5 + 0.49 * x; });
    EXPECT_EQ(lines_of(slope, 1).size(), 20u);
}

TEST(HeightLine, WhatIsNotHitHasNone) {
    const ReliefScene s(40, 40, [](double x, double y) {
        return std::abs(y) < 3 ? std::numeric_limits<double>::quiet_NaN() : 0.3 + 0.2 * x;
    });
    for (const HeightLine& line : lines_of(s, 1))
        for (const PicturePoint& p : line.points) EXPECT_GT(std::abs(p.y - 20), 2.9f);
}

TEST(HeightLine, TooCloseOnesAreLeftToTheIndexContours) {
    const ReliefScene s(40, 40, [](double x, double) { return 0.7 * x; });
    // Lines a twentieth of a pixel apart; each fifth is four a pixel.
    for (const HeightLine& line : lines_of(s, 0.035)) EXPECT_EQ(line.level % 5, 0);
    EXPECT_FALSE(lines_of(s, 0.035).empty());
    EXPECT_TRUE(lines_of(s, 1e-300).empty());
}

TEST(HeightLine, EdgesHaveTheirPlacesInTheWholePicture) {
    const ReliefScene s(40, 40, [](double x, double) { return x + 0.25; });
    HeightLineSearch search(s.relief, 10);
    search.add(s.scene({100, 900, 0, 0}), 7);
    const auto lines = search.finish().value();
    for (const HeightLine& line : lines)
        for (const PicturePoint& p : line.points) {
            EXPECT_GT(p.y, 100);
            EXPECT_NEAR(std::remainder(static_cast<double>(p.x) - 27 + 0.25, 10.0), 0, 1e-4);
        }
}

}  // namespace
}  // namespace slim
