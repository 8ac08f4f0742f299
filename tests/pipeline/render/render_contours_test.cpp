#include "tests/pipeline/render/render_outputs_support.h"

#include "raytrace/panel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

// Contour lines of a relief: heights on index contours, in the picture and as a drawing.

namespace slim {
namespace {

class RenderContours : public test::RenderOutputs {
protected:
    /// A ball of radius 1 from above; index contours at half its height and about its middle.
    RenderConfig relief(const std::string& output) const {
        RenderConfig c = config(output);
        c.aov = {"hillshade"}, c.contours = "0.1", c.size = "600x600", c.unit = "m";
        c.up = "z", c.camera = "top", c.ortho = true, c.legend = false, c.background = "white";
        return c;
    }
    std::string drawing(const RenderConfig& c, const std::string& name = "x.contours.svg") {
        run(c);
        return bytes(name);
    }
    /// The rows and columns of a part.
    static std::vector<std::uint8_t> part_of(const PngImage& whole, int x, int y, int width,
                                             int height) {
        std::vector<std::uint8_t> out;
        for (int row = y; row < y + height; ++row)
            out.insert(out.end(), test::pixel(whole, x, row), test::pixel(whole, x, row) + 4 * width);
        return out;
    }
    /// Columns and rows in which two pictures differ.
    PixelBox difference(const PngImage& a, const PngImage& b) const {
        PixelBox box{1e9f, 1e9f, -1, -1};
        for (int y = 0; y < a.height; ++y)
            for (int x = 0; x < a.width; ++x) {
                if (std::equal(test::pixel(a, x, y), test::pixel(a, x, y) + 4, test::pixel(b, x, y)))
                    continue;
                const auto u = static_cast<float>(x), v = static_cast<float>(y);
                box = {std::min(box.x0, u), std::min(box.y0, v), std::max(box.x1, u),
                       std::max(box.y1, v)};
            }
        return box;
    }
};

TEST_F(RenderContours, HeightsStandOnIndexContoursInThePictureAndTheDrawing) {
    RenderConfig c = relief("x.png");
    const std::string svg = drawing(c);
    EXPECT_NE(svg.find(">0.5 m</text>"), std::string::npos) << svg.substr(0, 2000);
    EXPECT_EQ(svg.find(">0.4 m<"), std::string::npos);
    // The picture differs by its unit where the drawing has its text, and nowhere else.
    const PngImage metres = read_png(c.output);
    c.unit = "ft";
    const PixelBox changed = difference(metres, draw(c));
    const std::size_t at = svg.rfind("translate(", svg.find(">0.5 m<"));
    const double x = std::stod(svg.substr(at + 10)) * 96 / 25.4;
    const double y = std::stod(svg.substr(svg.find(',', at) + 1)) * 96 / 25.4;
    EXPECT_NEAR(static_cast<double>(changed.x0 + changed.x1) / 2, x, 25);
    EXPECT_NEAR(static_cast<double>(changed.y0 + changed.y1) / 2, y, 12);
    EXPECT_LT(changed.x1 - changed.x0, 70);
    // On the circle of that height: sqrt(1 - 0.5^2) of the ball's radius, 0.46 of the picture.
    EXPECT_NEAR(std::hypot(x - 300, y - 300), 0.8660 * 0.48 * 600, 6);
}

TEST_F(RenderContours, HeightsAreThoseOfTheWorld) {
    SurfelTreeData model = test::sphere_model(1, 600);
    model.header.origin = {636850, 851450, 400};
    write_model(file("m.slim"), model, "{}");
    RenderConfig c = relief("x.png");
    EXPECT_NE(drawing(c).find(">400.5 m</text>"), std::string::npos);
    c.unit.clear();
    EXPECT_NE(drawing(c).find(">400.5</text>"), std::string::npos);
}

TEST_F(RenderContours, WithoutContoursThereIsNoDrawing) {
    RenderConfig c = relief("x.png");
    c.contours = "none";
    EXPECT_EQ(run(c)["files"].size(), 1u);
    c.contours = "auto", c.aov = {"mean"}, c.output = file("y.png");
    run(c);
    EXPECT_FALSE(exists("x.contours.svg"));
    EXPECT_FALSE(exists("y.contours.svg"));
    c.contours = "0.1", c.aov = {"hillshade"}, c.output = file("x.hillshade.png");
    EXPECT_EQ(run(c)["files"].size(), 2u);
    EXPECT_TRUE(exists("x.contours.svg"));
}

TEST_F(RenderContours, FilmsHaveLinesWithoutHeights) {
    RenderConfig c = relief("film.png");
    c.turntable = 2;
    run(c);
    const PngImage first = read_png(file("film_0001.png"));
    EXPECT_FALSE(exists("film_0001.contours.svg"));
    c.unit = "ft";
    run(c);
    EXPECT_EQ(read_png(file("film_0001.png")).rgba, first.rgba);
}

TEST_F(RenderContours, PartsShowTheHeightsOfTheWhole) {
    for (const int supersample : {1, 2}) {
        RenderConfig c = relief("whole.png");
        c.supersample = supersample, c.size = "1100x1100";  // larger than what decides
        const std::string svg = drawing(c, "whole.contours.svg");
        const PngImage whole = read_png(c.output);
        const std::size_t at = svg.find("translate(");
        ASSERT_NE(at, std::string::npos);
        // A part whose edge cuts through a height.
        const int x = static_cast<int>(std::stod(svg.substr(at + 10)) * 96 / 25.4);
        c.output = file("part.png"), c.crop = std::to_string(x) + ",300,400,700";
        run(c);
        EXPECT_EQ(read_png(c.output).rgba, part_of(whole, x, 300, 400, 700)) << supersample;
        const std::string of_part = bytes("part.contours.svg");
        EXPECT_NE(of_part.find("height=\"185.208mm\""), std::string::npos);
        EXPECT_EQ(of_part.substr(of_part.find("<g id=\"contour-heights\"")),
                  svg.substr(svg.find("<g id=\"contour-heights\"")));
    }
}

TEST_F(RenderContours, AveragedPicturesHaveTheSameDrawing) {
    RenderConfig c = relief("x.png");
    const std::string plain = drawing(c);
    c.supersample = 2;
    EXPECT_EQ(drawing(c), plain);
}

}  // namespace
}  // namespace slim
