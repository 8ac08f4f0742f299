#include "slim/base/error.h"
#include "tests/pipeline/render/render_test_support.h"
#include "tests/raytrace/support/sharp_models.h"

#include <algorithm>
#include <numbers>
#include <string>

namespace slim {
namespace {

class RenderLines : public test::RenderTest {
protected:
    RenderConfig lines(const std::string& output, std::vector<std::string> kinds) const {
        RenderConfig c = config(output);
        c.size = "200x150";
        c.lines = std::move(kinds);
        return c;
    }
};

TEST_F(RenderLines, AreDrawnOverThePictureAndCounted) {
    RenderConfig c = lines("a.png", {"contour"});
    const auto result = run(c);
    EXPECT_EQ(result["lines"]["contour"]["polylines"], 1);
    EXPECT_NEAR(result["lines"]["contour"]["length"].get<double>(), 2 * std::numbers::pi, 0.25);
    EXPECT_TRUE(exists("a.lines.svg"));
    c.lines.clear(), c.output = file("b.png");
    EXPECT_FALSE(run(c).contains("lines"));
    EXPECT_FALSE(exists("b.lines.svg"));
    EXPECT_NE(bytes("a.png"), bytes("b.png"));
}

TEST_F(RenderLines, AloneAreDarkOnWhite) {
    RenderConfig c = lines("a.png", {"contour"});
    c.aov = {"lines"};
    const PngImage image = draw(c);
    std::size_t white = 0, dark = 0;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
        white += image.rgba[i] == 255;
        dark += image.rgba[i] < 200;
        EXPECT_EQ(image.rgba[i + 3], 255);
    }
    EXPECT_GT(white, 200u * 150 * 9 / 10);
    EXPECT_GT(dark, 200u);
}

TEST_F(RenderLines, AloneOnADarkBackgroundAreLightThereAndInTheSvg) {
    RenderConfig c = lines("a.png", {"contour"});
    c.aov = {"lines"}, c.background = "black";
    const PngImage image = draw(c);
    std::size_t black = 0, light = 0;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4)
        black += image.rgba[i] == 0, light += image.rgba[i] > 200;
    EXPECT_GT(black, 200u * 150 * 9 / 10);
    EXPECT_GT(light, 100u);
    EXPECT_NE(bytes("a.lines.svg").find("<g id=\"contour\" stroke=\"#f2f2f0\">"),
              std::string::npos);
    // Over a drawn surface they stay dark, beside the background they are light.
    c.aov = {"shaded"};
    const PngImage over = draw(c);
    c.lines.clear();
    const PngImage plain = draw(c);
    const auto red = [](const PngImage& image, int x, int y) {
        return image.rgba[static_cast<std::size_t>(4 * (200 * y + x))];
    };
    constexpr int kReach = 4;  // of the stroke and of what is looked at about it
    int lightened = 0;
    for (int y = kReach; y < 150 - kReach; ++y)
        for (int x = kReach; x < 200 - kReach; ++x) {
            bool is_inside = true;
            for (int dy = -kReach; dy <= kReach; ++dy)
                for (int dx = -kReach; dx <= kReach; ++dx)
                    is_inside &= red(plain, x + dx, y + dy) > 0;
            if (is_inside) EXPECT_LE(red(over, x, y), std::max<int>(red(plain, x, y), 15)) << x;
            else lightened += red(over, x, y) > 200;
        }
    EXPECT_GT(lightened, 100);
}

TEST_F(RenderLines, AreTheSameWithSupersampling) {
    RenderConfig c = lines("a.png", {"contour", "reflection"});
    const auto plain = run(c);
    c.supersample = 2, c.output = file("b.png");
    EXPECT_EQ(run(c)["lines"], plain["lines"]);
}

TEST_F(RenderLines, StandInTheExrUnderTheirNames) {
    RenderConfig c = lines("a.exr", {"contour", "suggestive"});
    run(c);
    const ExrImage image = read_exr(c.output);
    const auto& contour = image.channels.at("marks.contour").floats;
    EXPECT_EQ(image.channels.count("lines.suggestive"), 1u);
    EXPECT_EQ(image.channels.count("lines.crest"), 0u);
    std::size_t n = 0;
    for (const float v : contour) n += v > 0;
    EXPECT_GT(n, 200u);
    EXPECT_LT(n, 1500u);
}

TEST_F(RenderLines, CrestLinesNeedACubicModel) {
    EXPECT_THROW(run(lines("a.png", {"crest"})), ConfigError);
    const auto both = run(lines("a.png", {"crest", "contour"}));
    EXPECT_FALSE(both["lines"].contains("ridge"));
    write_model(file("m.slim"), test::sphere_model(1, 600, 3), "{}");
    const auto cubic = run(lines("b.png", {"crest"}));
    EXPECT_EQ(cubic["lines"]["ridge"]["polylines"], 0);
    EXPECT_EQ(cubic["lines"]["valley"]["polylines"], 0);
}

TEST_F(RenderLines, CreasesNeedASharpModel) {
    try {
        run(lines("a.png", {"crease"}));
        FAIL() << "a smooth model has no creases";
    } catch (const ConfigError& e) {
        EXPECT_NE(std::string(e.what()).find("--sharp on"), std::string::npos) << e.what();
    }
    const auto both = run(lines("a.png", {"crease", "contour"}));
    EXPECT_FALSE(both["lines"].contains("convex_crease"));
    EXPECT_FALSE(both["lines"].contains("concave_crease"));
}

TEST_F(RenderLines, CreasesOfACubeStandInAllOutputs) {
    write_model(file("m.slim"), test::flat_tree(test::cube_leaves(), 2), "{}");
    RenderConfig c = lines("a.exr", {"crease"});
    c.camera = "iso", c.lines_ply = file("a.ply"), c.lines_obj = file("a.obj");
    const auto result = run(c);
    EXPECT_EQ(result["lines"]["convex_crease"]["polylines"], 9);
    // a mean, in degrees
    EXPECT_NEAR(result["lines"]["convex_crease"]["strength"].get<double>(), 90, 0.1);
    EXPECT_EQ(result["lines"]["concave_crease"]["polylines"], 0);
    const std::string svg = bytes("a.lines.svg");
    EXPECT_NE(svg.find("<g id=\"crease-convex\""), std::string::npos);
    EXPECT_NE(svg.find("<g id=\"crease-concave\""), std::string::npos);
    EXPECT_NE(bytes("a.obj").find("o convex_crease"), std::string::npos);
    EXPECT_NE(bytes("a.ply").find("comment type 6 convex_crease"), std::string::npos);
    const ExrImage image = read_exr(c.output);
    const auto& convex = image.channels.at("creases.convex").floats;
    EXPECT_NEAR(*std::max_element(convex.begin(), convex.end()), 90, 0.1);
    std::size_t n = 0;
    for (const float v : convex) n += v > 0;
    EXPECT_GT(n, 200u);
    for (const float v : image.channels.at("creases.concave").floats) ASSERT_EQ(v, 0);
}

TEST_F(RenderLines, AloneCreasesOfASharpModelAreAmongThem) {
    write_model(file("m.slim"), test::flat_tree(test::cube_leaves(), 2), "{}");
    RenderConfig c = lines("a.png", {});
    c.aov = {"lines"}, c.camera = "iso";
    // Six of the nine that are seen are the outline, which is one line.
    const auto result = run(c);
    EXPECT_EQ(result["lines"]["convex_crease"]["polylines"], 3);
    EXPECT_EQ(result["lines"]["contour"]["polylines"], 1);
    // Of two models as well.
    c.add = {file("n.slim")}, c.mode = "raytrace";
    SurfelTreeData beside = test::flat_tree(test::cube_leaves(), 2);
    beside.header.origin = {40, 0, 0};
    write_model(file("n.slim"), beside, "{}");
    c.camera = "30,40,50,0,0,0,0,0,1", c.ortho_width = 4;
    EXPECT_EQ(run(c)["lines"]["convex_crease"]["polylines"], 3);
}

TEST_F(RenderLines, CreasesOfSeveralModelsAreHiddenByAll) {
    write_model(file("m.slim"), test::flat_tree(test::cube_leaves(), 2), "{}");
    SurfelTreeData before = test::flat_tree(test::cube_leaves(), 2);
    before.header.origin = {0.5, -3, 0.5};  // nearer to a camera that looks along +y
    write_model(file("n.slim"), before, "{}");
    RenderConfig c = lines("a.png", {"crease"});
    c.camera = "0.3,-20,0.3,0.3,0,0.3,0,0,1", c.ortho_width = 6, c.mode = "raytrace";
    c.add = {file("n.slim")};
    const auto result = run(c);
    // The front faces: one whole, of the other's two sides lie behind it for three quarters each.
    const double px = 200.0 / 6;
    EXPECT_NEAR(result["lines"]["convex_crease"]["length_px"].get<double>(), (8 + 4 + 2 * 0.5) * px,
                1.3 * px);
    c.add.clear(), c.output = file("b.png");
    EXPECT_NEAR(run(c)["lines"]["convex_crease"]["length_px"].get<double>(), 8 * px, 0.8 * px);
}

TEST_F(RenderLines, FilesInSpaceAreWrittenWhereNamed) {
    RenderConfig c = lines("a.png", {"contour"});
    c.lines_ply = file("a.ply"), c.lines_obj = file("a.obj");
    const auto result = run(c);
    EXPECT_EQ(result["files"].size(), 4u);
    EXPECT_TRUE(exists("a.ply") && exists("a.obj"));
    const auto refusal = [&]() -> std::string {
        try {
            run(c);
        } catch (const ConfigError& error) {
            return error.what();
        }
        return "none";
    };
    c.turntable = 3;
    EXPECT_EQ(refusal(), "lines_ply is for one picture, not for a turntable or path");
    c.lines.clear(), c.turntable = 0;
    const std::string rest =
        " is for a drawing of lines, which is not asked for: --lines or --aov lines";
    EXPECT_EQ(refusal(), "lines_ply" + rest);
    c.lines_ply.clear();
    EXPECT_EQ(refusal(), "lines_obj" + rest);
}

}  // namespace
}  // namespace slim
