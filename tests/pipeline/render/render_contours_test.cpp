#include "tests/pipeline/render/render_outputs_support.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

// Contour lines of a relief: heights on index contours, in the picture and as a drawing.

namespace slim {
namespace {

using test::pixel;

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
            out.insert(out.end(), pixel(whole, x, row), pixel(whole, x, row) + 4 * width);
        return out;
    }
    /// Of the drawing of a picture so many pixels wide.
    static double mm_per_pixel(const std::string& svg, int width) {
        return std::stod(svg.substr(svg.find("width=\"") + 7)) / width;
    }
    /// Places of the heights of a drawing, in pixels.
    static std::vector<std::array<double, 2>> places_of(const std::string& svg, double mm) {
        std::vector<std::array<double, 2>> places;
        for (std::size_t at = 0; (at = svg.find("translate(", at)) != std::string::npos; ++at)
            places.push_back({std::stod(svg.substr(at + 10)) / mm,
                              std::stod(svg.substr(svg.find(',', at) + 1)) / mm});
        return places;
    }
};

TEST_F(RenderContours, HeightsStandOnIndexContoursInThePictureAndTheDrawing) {
    RenderConfig c = relief("x.png");
    const std::string svg = drawing(c);
    EXPECT_NE(svg.find(">0.5 m</text>"), std::string::npos) << svg.substr(0, 2000);
    EXPECT_EQ(svg.find(">0.4 m<"), std::string::npos);
    // The picture differs by its unit where the drawings have their text, and nowhere else.
    const PngImage metres = read_png(c.output);
    c.unit = "ft";
    const std::string in_feet = drawing(c);
    const PngImage feet = read_png(c.output);
    const auto places = places_of(svg, mm_per_pixel(svg, 600)),
               others = places_of(in_feet, mm_per_pixel(in_feet, 600));
    std::vector<int> changed(places.size(), 0);
    for (int y = 0; y < 600; ++y)
        for (int x = 0; x < 600; ++x) {
            if (std::equal(pixel(metres, x, y), pixel(metres, x, y) + 4, pixel(feet, x, y)))
                continue;
            const auto is_near = [&](const auto& at) {
                return std::hypot(x - at[0], y - at[1]) < 35;
            };
            for (std::size_t k = 0; k < places.size(); ++k) changed[k] += is_near(places[k]);
            ASSERT_TRUE(std::any_of(places.begin(), places.end(), is_near) ||
                        std::any_of(others.begin(), others.end(), is_near))
                << x << " " << y;
        }
    for (const int n : changed) EXPECT_GT(n, 10);
    // On the circle of that height: sqrt(1 - 0.5^2) of the ball's radius, 0.96 of half the picture.
    const auto at = places_of(svg.substr(svg.rfind("translate(", svg.find(">0.5 m<"))),
                              mm_per_pixel(svg, 600))
                        .front();
    EXPECT_NEAR(std::hypot(at[0] - 300, at[1] - 300), 0.8660 * 0.96 * 300, 6);
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

TEST_F(RenderContours, WithoutAHeavyLineOthersHaveHeights) {
    SurfelTreeData model = test::sphere_model(1, 600);
    model.header.origin = {0, 0, 0.5};
    write_model(file("m.slim"), model, "{}");
    RenderConfig c = relief("x.png");
    c.contours = "0.4";  // heavy ones at 0 and 2 m; from above 0.5 to 1.5 m are seen
    EXPECT_NE(drawing(c).find(">0.8 m</text>"), std::string::npos);
    c.contours = "0.2";  // and at 1 m
    const std::string svg = drawing(c);
    EXPECT_NE(svg.find(">1 m</text>"), std::string::npos);
    EXPECT_EQ(svg.find(">0.8 m</text>"), std::string::npos);
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

/// What a run warns of.
class Warnings : public Reporter {
public:
    void warn(const std::string& text) override { text_ += text + "\n"; }
    std::string text_;
};

TEST_F(RenderContours, ASpacingWithoutALineIsSaidAndHasNoLegendAndNoDrawing) {
    SurfelTreeData model = test::sphere_model(1, 600);
    model.header.origin = {0, 0, 400.5};  // 400.5 to 401.5 m are seen
    write_model(file("m.slim"), model, "{}");
    RenderConfig c = relief("x.png");
    c.legend = true, c.contours = "1000";
    c.camera = "0,0,410,0,0,400.5,0,1,0", c.ortho_width = 3;
    Warnings said;
    const auto result = run(c, false, said);
    for (const char* word : {"every 1000 m", "400.49 to 401.50 m", "every 0.05"})
        EXPECT_NE(said.text_.find(word), std::string::npos) << word << ": " << said.text_;
    EXPECT_EQ(result["contours"]["lines"], 0);
    EXPECT_EQ(result["contours"]["spacing"], 1000);
    EXPECT_NEAR(result["contours"]["heights"][1].get<double>(), 401.5, 1e-3);
    EXPECT_EQ(result["files"].size(), 1u) << result["files"];  // no legend, no lines
    const auto drawn = read_png(c.output).rgba;
    c.contours = "none";
    EXPECT_EQ(draw(c).rgba, drawn);
}

TEST_F(RenderContours, TheLegendNamesHeavyLinesWhereThereAreSome) {
    RenderConfig c = relief("x.png");
    c.legend = true;
    Warnings said;
    const auto legend_with = [&](const char* spacing) {
        c.contours = spacing;
        run(c, false, said);
        return bytes("x.hillshade.legend.svg");
    };
    const std::string with = legend_with("0.1");  // heavy at 0 and 0.5
    EXPECT_NE(with.find("every 0.1 m"), std::string::npos);
    EXPECT_NE(with.find("heavy every 0.5 m"), std::string::npos);
    SurfelTreeData model = test::sphere_model(1, 600);
    model.header.origin = {0, 0, 0.5};  // 0.5 to 1.5 m are seen
    write_model(file("m.slim"), model, "{}");
    const std::string without = legend_with("0.4");  // heavy at 0 and 2 m
    EXPECT_NE(without.find("every 0.4 m"), std::string::npos);
    EXPECT_EQ(without.find("heavy"), std::string::npos) << without;
    EXPECT_EQ(said.text_, "");
}

TEST_F(RenderContours, LinesTooManyForADrawingAreSaidAndPainted) {
    RenderConfig c = relief("x.png");
    c.size = "2000x2000", c.contours = "0.0003";  // a third of a pixel apart and less
    Warnings said;
    EXPECT_EQ(run(c, false, said)["files"].size(), 1u);
    for (const char* word : {"x.contours.svg: not written", "0.0003 m", "8 million"})
        EXPECT_NE(said.text_.find(word), std::string::npos) << word << ": " << said.text_;
}

TEST_F(RenderContours, AFilmsLinesAreHeldAgainstAllOfTheModel) {
    RenderConfig c = relief("film.png");
    c.turntable = 2, c.legend = true;
    c.contours = "0.9";  // 0.9 is seen from above, -0.9 and 0 are not
    EXPECT_EQ(run(c)["contours"]["lines"], 3);
    EXPECT_TRUE(exists("film.hillshade.legend.svg"));
}

TEST_F(RenderContours, ADataFilesReliefIsHeldAgainstItsSpacing) {
    SurfelTreeData model = test::sphere_model(1, 600);
    model.header.origin = {0, 0, 1.5};
    write_model(file("m.slim"), model, "{}");
    RenderConfig c = relief("x.exr");
    c.aov = {"shaded", "hillshade"}, c.contours = "1000";
    Warnings said;
    EXPECT_EQ(run(c, false, said)["contours"]["lines"], 0);
    EXPECT_NE(said.text_.find("1000 m"), std::string::npos);
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
        const double mm = mm_per_pixel(svg, 1100);
        const int x = static_cast<int>(std::stod(svg.substr(at + 10)) / mm);
        c.output = file("part.png"), c.crop = std::to_string(x) + ",300,400,700";
        run(c);
        EXPECT_EQ(read_png(c.output).rgba, part_of(whole, x, 300, 400, 700)) << supersample;
        const std::string of_part = bytes("part.contours.svg");
        EXPECT_NEAR(mm_per_pixel(of_part, 400), mm, 1e-5);
        EXPECT_NE(of_part.find(fmt::format("height=\"{:.3f}mm\"", 700 * mm)), std::string::npos);
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
