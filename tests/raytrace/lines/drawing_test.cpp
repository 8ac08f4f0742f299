#include "raytrace/lines/ink_plane.h"
#include "raytrace/lines/lines_geometry.h"
#include "raytrace/lines/lines_svg.h"
#include "raytrace/lines/stroke.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>

namespace slim {
namespace {

FeatureLine line_of(LineKind kind, std::vector<Vec3f> points, float strength, bool closed = false) {
    FeatureLine line;
    line.kind = kind, line.closed = closed, line.strength = strength;
    for (const Vec3f& p : points) line.points.push_back({p.x, p.y, p, 1, 1});
    return line;
}

const std::vector<FeatureLine> kLines{
    line_of(LineKind::contour, {{10, 20.5f, 1}, {90, 20.5f, 1}}, 1),
    line_of(LineKind::ridge, {{20, 40, 2}, {40, 40, 2}, {30, 60, 2}}, 4, true)};

std::size_t count(const std::string& text, const std::string& part) {
    std::size_t n = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
        ++n;
    return n;
}

TEST(DrawLines, CoverTheirWidthAndNothingElse) {
    Picture picture(100, 100);
    for (float& v : picture.rgba) v = 1;
    draw_lines(std::span(kLines).first(1), picture);
    const float width = stroke_width(kLines[0], 100, 100);
    double covered = 0;
    for (int y = 0; y < 100; ++y) covered += 1 - picture.pixel(50, y)[0];
    EXPECT_NEAR(covered, width * (1 - linear_from_srgb(0.06f)), 0.1);
    EXPECT_EQ(picture.pixel(50, 30)[0], 1);
    EXPECT_EQ(picture.pixel(95, 20)[0], 1);
    EXPECT_EQ(picture.pixel(50, 20)[3], 1);
}

TEST(DrawLines, StrongerLinesAreWider) {
    EXPECT_LT(stroke_width(line_of(LineKind::ridge, {}, 1), 1000, 1000),
              stroke_width(line_of(LineKind::ridge, {}, 4), 1000, 1000));
}

TEST(DrawLines, DoNotDependOnBands) {
    // A slanted line crosses the bands that threads share out.
    const std::vector slanted{line_of(LineKind::contour, {{3, 2, 0}, {95, 197, 0}}, 1)};
    Picture tall(100, 200);
    draw_lines(slanted, tall);
    for (int y = 10; y < 190; ++y) {
        double covered = 0;
        for (int x = 0; x < 100; ++x) covered += tall.pixel(x, y)[3];
        EXPECT_NEAR(covered, 1.08 * std::hypot(92, 195) / 195, 0.25) << y;
    }
}

TEST(DrawLines, InkStandsOutFromTheBackground) {
    const auto grey = [](float linear) { return Vec3f{linear, linear, linear}; };
    EXPECT_EQ(ink_on({grey(1), grey(1), 1}), Ink::dark);
    EXPECT_EQ(ink_on({grey(0), grey(0), 1}), Ink::light);
    EXPECT_EQ(ink_on({grey(0), grey(0.02f), 1}), Ink::light);
    EXPECT_EQ(ink_on({grey(0.6f), grey(0.25f), 1}), Ink::dark);
    EXPECT_EQ(ink_on({{}, {}, 0}), Ink::dark);
    // Of every kind, on black as on white: a contrast of 3 at least,
    // as of graphics that must be seen (WCAG 2).
    for (const LineKind kind : kAllLineKinds)
        for (const Ink ink : {Ink::dark, Ink::light}) {
            const Vec3f c = line_style(kind, ink).srgb;
            const float own = 0.2126f * linear_from_srgb(c.x) + 0.7152f * linear_from_srgb(c.y) +
                              0.0722f * linear_from_srgb(c.z);
            EXPECT_GT(ink == Ink::dark ? 1.05f / (own + 0.05f) : (own + 0.05f) / 0.05f, 3)
                << line_name(kind);
        }
    Picture picture(100, 100);
    draw_lines(std::span(kLines).first(1), picture, {Ink::light});
    EXPECT_GT(picture.pixel(50, 20)[0], 0.8f);
}

/// A grey surface in the left half of a picture.
Picture half_drawn() {
    Picture picture(100, 100);
    for (int y = 0; y < 100; ++y)
        for (int x = 0; x < 50; ++x)
            for (int i = 0; i < 4; ++i) picture.pixel(x, y)[i] = i < 3 ? 0.5f : 1.0f;
    return picture;
}

TEST(DrawLines, BesideTheSurfaceTheyTakeTheOtherInk) {
    Picture picture = half_drawn();
    const std::vector<float> plane = ink_plane(picture, {0, 0, 100, 100}, 100, 100);
    const auto outline = line_of(LineKind::contour, {{50, 10, 1}, {50, 90, 1}}, 1);
    draw_lines(std::vector{kLines[0], outline}, picture, {Ink::dark, plane});
    EXPECT_LT(picture.pixel(30, 20)[0], 0.05f);   // over the surface
    EXPECT_GT(picture.pixel(70, 20)[0], 0.8f);    // past it
    EXPECT_GT(picture.pixel(49, 50)[0], 0.5f);    // along the outline on both sides
    EXPECT_GT(picture.pixel(50, 50)[0], 0.25f);
    EXPECT_EQ(picture.pixel(40, 50)[0], 0.5f);
}

TEST(InkPlane, OfAPartIsThatOfTheWhole) {
    Picture drawn = half_drawn();
    for (int x = 20; x < 30; ++x) drawn.pixel(x, 60)[3] = 0.25f;
    const std::vector<float> whole = ink_plane(drawn, {0, 0, 100, 100}, 100, 100);
    const std::vector<float> part = ink_plane(drawn, {15, 57, 40, 20}, 100, 100);
    for (int y = 0; y < 20; ++y)
        for (int x = 0; x < 40; ++x)
            EXPECT_EQ(part[static_cast<std::size_t>(40 * y + x)],
                      whole[drawn.index(15 + x, 57 + y)]);
    EXPECT_EQ(whole[drawn.index(25, 62)], 0.75f);
    EXPECT_EQ(whole[drawn.index(25, 70)], 0);
}

TEST(InkPlane, AShadowHidesNothing) {
    Picture drawn(10, 10);
    for (std::size_t i = 0; i < drawn.n_pixels(); ++i) drawn.rgba[4 * i + 3] = 0.9f;
    EXPECT_EQ(ink_plane(drawn, {0, 0, 10, 10}, 10, 10), std::vector<float>(100, 1.0f));
}

TEST(LinesSvg, LightInkHasItsBackgroundUnderIt) {
    const std::vector kinds{LineKind::contour};
    const PixelWindow all{0, 0, 96, 96};
    EXPECT_EQ(lines_svg(kLines, kinds, 96, 96, all).find("background"), std::string::npos);
    const std::string black = lines_svg(kLines, kinds, 96, 96, all, {{0, 0, 0}, {0, 0, 0}, 1});
    EXPECT_NE(black.find("<rect id=\"background\" width=\"25.400\" height=\"25.400\" "
                         "stroke=\"none\" fill=\"#000000\"/>"),
              std::string::npos)
        << black;
    EXPECT_NE(black.find("<g id=\"contour\" stroke=\"#f2f2f0\">"), std::string::npos) << black;
    const std::string shade =
        lines_svg(kLines, kinds, 96, 96, all, {{0, 0, 0}, {0.01f, 0.01f, 0.01f}, 1});
    EXPECT_EQ(count(shade, "<stop "), 2u);
    EXPECT_EQ(count(shade, "fill=\"url(#shade)\""), 1u);
}

TEST(LinesSvg, IsAsLargeAsItsScaleSays) {
    const PixelWindow all{0, 0, 960, 480};
    const std::vector kinds{LineKind::ridge, LineKind::valley, LineKind::contour};
    const std::string large = lines_svg(kLines, kinds, 960, 480, all, {}, SvgScale(2.0));
    EXPECT_NE(large.find("width=\"1920.000mm\" height=\"960.000mm\" "
                         "viewBox=\"0 0 1920.000 960.000\""),
              std::string::npos)
        << large;
    EXPECT_NE(large.find("M20.000,41.000 180.000,41.000"), std::string::npos) << large;
    // A micrometre a pixel: a thousandth of a pixel is kept all the same.
    const std::string small = lines_svg(kLines, kinds, 960, 480, all, {}, SvgScale(1e-3));
    EXPECT_NE(small.find("M0.010000,0.020500 0.090000,0.020500"), std::string::npos) << small;
}

TEST(StrengthPlane, HoldsTheStrengthUnfiltered) {
    const auto plane =
        strength_plane(kLines, std::vector{LineKind::ridge}, 100, 100, {0, 0, 100, 100});
    EXPECT_EQ(plane[40 * 100 + 20], 4);
    EXPECT_EQ(plane[20 * 100 + 10], 0);  // another kind
}

TEST(LinesSvg, HasAGroupForEachKindInMillimetres) {
    const std::string svg =
        lines_svg(kLines, std::vector{LineKind::ridge, LineKind::valley, LineKind::contour}, 960,
                  480, {0, 0, 960, 480});
    EXPECT_NE(svg.find("width=\"254.000mm\" height=\"127.000mm\" viewBox=\"0 0 254.000 127.000\""),
              std::string::npos);
    for (const char* id : {"crest-ridge", "crest-valley", "contour"})
        EXPECT_EQ(count(svg, "<g id=\"" + std::string(id) + "\""), 1u);
    EXPECT_EQ(count(svg, "<path "), 2u);
    EXPECT_EQ(count(svg, " Z\""), 1u);
    EXPECT_NE(svg.find("M2.646,5.424 23.812,5.424"), std::string::npos) << svg;
}

TEST(LinesPly, HasVerticesAndEdges) {
    const std::string ply = lines_ply(kLines, {1, 2, 3});
    EXPECT_NE(ply.find("comment slim origin 1 2 3\n"), std::string::npos);
    EXPECT_NE(ply.find("element vertex 5\n"), std::string::npos);
    EXPECT_NE(ply.find("element edge 4\n"), std::string::npos);  // 1 and, closed, 3
    const std::size_t body = ply.find("end_header\n") + 11;
    ASSERT_EQ(ply.size(), body + 5 * 21 + 4 * 8);
    std::int32_t last[2];
    std::memcpy(last, ply.data() + ply.size() - 8, 8);
    EXPECT_EQ(last[0], 4);
    EXPECT_EQ(last[1], 2);
}

TEST(LinesObj, HasALinePerPolyline) {
    const std::string obj = lines_obj(kLines, {});
    EXPECT_EQ(count(obj, "\nv "), 5u);
    EXPECT_NE(obj.find("l 1 2\n"), std::string::npos);
    EXPECT_NE(obj.find("l 3 4 5 3\n"), std::string::npos);
    EXPECT_NE(obj.find("o ridge\n"), std::string::npos);
}

}  // namespace
}  // namespace slim
