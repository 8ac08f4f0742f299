#include "raytrace/lines/height_svg.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

namespace slim {
namespace {

HeightLine straight(std::int64_t level, float y) {
    HeightLine line{level, false, {}};
    for (int x = 0; x <= 960; ++x) line.points.push_back({static_cast<float>(x), y});
    return line;
}

HeightLine ring(std::int64_t level, float radius) {
    HeightLine line{level, true, {}};
    for (int i = 0; i < 1000; ++i) {
        const float t = 6.2831853f * static_cast<float>(i) / 1000;
        line.points.push_back({480 + radius * std::cos(t), 480 + radius * std::sin(t)});
    }
    return line;
}

/// The text between a group's tag and its end.
std::string group(const std::string& svg, const std::string& id) {
    const std::size_t from = svg.find("<g id=\"" + id + "\"");
    return from == std::string::npos ? "" : svg.substr(from, svg.find("</g>", from) - from);
}

std::size_t n_paths(const std::string& text) {
    std::size_t n = 0;
    for (std::size_t at = 0; (at = text.find("<path", at)) != std::string::npos; ++at) ++n;
    return n;
}

/// All places of paths, millimetres.
std::vector<PicturePoint> places(const std::string& text) {
    std::vector<PicturePoint> out;
    for (std::size_t at = 0; (at = text.find_first_of("M ", at)) != std::string::npos; ++at) {
        char* end = nullptr;
        const float x = std::strtof(&text[at] + 1, &end);
        if (*end == ',') out.push_back({x, std::strtof(end + 1, nullptr)});
    }
    return out;
}

const std::vector<HeightLine> kLines{straight(9, 100), straight(10, 200), ring(15, 100)};
const PixelWindow kAll{0, 0, 960, 960};

TEST(HeightSvg, IndexContoursAreAGroupOfTheirOwnAndWider) {
    const std::string svg = height_svg(kLines, {}, 5, 1, kAll);
    EXPECT_NE(svg.find("width=\"254.000mm\" height=\"254.000mm\""), std::string::npos);
    EXPECT_EQ(n_paths(group(svg, "contour-lines")), 1u);
    EXPECT_EQ(n_paths(group(svg, "index-contours")), 2u);
    const auto width = [&](const char* id) {
        const std::string text = group(svg, id);
        return std::stod(text.substr(text.find("stroke-width=\"") + 14));
    };
    EXPECT_GT(width("index-contours"), 2 * width("contour-lines"));
    // A straight line of 961 points is two, a ring stays round to a sixth of a pixel.
    EXPECT_EQ(places(group(svg, "contour-lines")).size(), 2u);
    EXPECT_LT(places(group(svg, "index-contours")).size(), 120u);
    EXPECT_GT(places(group(svg, "index-contours")).size(), 40u);
}

TEST(HeightSvg, HeightsAreTextInMillimetresAndTheirLineHasAGap) {
    HeightLabel label{"50 m & up", 480, 200, 0.5f, 60, 12};
    const HeightLabel on_ring{"75 m", 580, 480, 1.5707963f, 40, 12};
    const std::string svg = height_svg(kLines, std::vector{label, on_ring}, 5, 1, kAll);
    const std::string heights = group(svg, "contour-heights");
    EXPECT_NE(heights.find("translate(127.000,52.917) rotate(28.65)"), std::string::npos)
        << heights;
    EXPECT_NE(heights.find("rotate(90.00)"), std::string::npos);
    EXPECT_NE(heights.find(">50 m &amp; up</text>"), std::string::npos);
    const std::string index = group(svg, "index-contours");
    EXPECT_EQ(n_paths(index), 3u);  // the straight one is two, the ring one that is open
    for (const PicturePoint& mm : places(index)) {
        const float x = mm.x * 96 / 25.4f, y = mm.y * 96 / 25.4f;
        EXPECT_GT(seen_beside(label, x, y), 0.45f);
        EXPECT_GT(seen_beside(on_ring, x, y), 0.45f);
    }
    // The line between the two goes on beneath none of them.
    EXPECT_EQ(n_paths(group(svg, "contour-lines")), 1u);
}

TEST(HeightSvg, APartShowsItsWindowOfTheWhole) {
    const std::string svg = height_svg(kLines, {}, 5, 1, {96, 192, 96, 48});
    EXPECT_NE(svg.find("viewBox=\"25.400 50.800 25.400 12.700\""), std::string::npos) << svg;
}

}  // namespace
}  // namespace slim
