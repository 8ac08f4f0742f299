#include "pipeline/render/render_stage.h"

#include "pipeline/render/render_aov.h"
#include "slim/base/error.h"
#include "slim/base/parallel.h"
#include "tests/pipeline/render/render_test_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

namespace slim {
namespace {

using RenderStage = test::RenderTest;
using test::pixel;

TEST_F(RenderStage, DrawsASphereOfTheRightSize) {
    RenderConfig c = config("x.png");
    c.size = "200x100";
    c.ortho_width = 8;  // 25 pixels per unit
    const auto result = run(c);
    EXPECT_EQ(result["width"], 200);
    EXPECT_EQ(result["height"], 100);
    EXPECT_NEAR(result["covered_pixels"].get<double>(), 3.14159 * 25 * 25, 60);
    EXPECT_GT(result["surfels_drawn"].get<int>(), 0);
    EXPECT_GT(result["root_tests"].get<int>(), 0);
    EXPECT_GT(result["distance_tests"].get<int>(), 0);
    EXPECT_GT(result["frame_ms_median"].get<double>(), 0);
    const PngImage image = read_png(c.output);
    EXPECT_EQ(image.width, 200);
    EXPECT_EQ(image.height, 100);
}

TEST_F(RenderStage, ZoomEnlargesAboutTheMiddle) {
    RenderConfig c = config("x.png");
    c.ortho_width = 8;
    const double plain = run(c)["covered_pixels"];
    c.zoom = 2;
    EXPECT_NEAR(run(c)["covered_pixels"].get<double>() / plain, 4, 0.15);
}

TEST_F(RenderStage, CurvatureOfPlanesIsWarnedOf) {
    struct : Reporter {
        void warn(const std::string& text) override { warnings += text; }
        std::string warnings;
    } listener;
    const auto warnings_of = [&](int degree, const char* aov) {
        write_model(file("m.slim"), test::sphere_model(1, 600, degree), "{}");
        RenderConfig c = config("x.png");
        c.aov = {aov};
        listener.warnings.clear();
        StageContext context{listener, 1, true, "render", "", "", ""};
        run_render(c, context);
        return listener.warnings;
    };
    EXPECT_NE(warnings_of(1, "mean").find("--degree 2"), std::string::npos);
    EXPECT_EQ(warnings_of(1, "shaded").find("--degree 2"), std::string::npos);
    EXPECT_EQ(warnings_of(2, "mean").find("--degree 2"), std::string::npos);
}

// Whatever an option is called: a picture that ignores it fails here.
TEST_F(RenderStage, EveryOptionChangesThePicture) {
    const auto mean = [](RenderConfig& c) { c.aov = {"mean"}, c.size = "500x400"; };
    const auto nothing = [](RenderConfig&) {};
    const auto shape = [](RenderConfig& c) {
        c.aov = {"truth_distance"}, c.truth_shape = "sphere", c.range = {"0.1"};
    };
    const OptionCase cases[] = {
        {"camera", nothing, [](RenderConfig& c) { c.camera = "0,0,9,0,0,0,0,1,0"; }},
        {"fov", [](RenderConfig& c) { c.camera = "0,0,5,0,0,0,0,1,0"; },
         [](RenderConfig& c) { c.fov = 60; }},
        {"ortho", nothing, [](RenderConfig& c) { c.ortho = true; }},
        {"ortho_width", nothing, [](RenderConfig& c) { c.ortho_width = 9; }},
        {"up", [](RenderConfig& c) { c.aov = {"position"}; }, [](RenderConfig& c) { c.up = "z"; }},
        {"up, other way", [](RenderConfig& c) { c.up = "y", c.aov = {"position"}; },
         [](RenderConfig& c) { c.up = "-y"; }},
        {"zoom", nothing, [](RenderConfig& c) { c.zoom = 2; }},
        {"zoom, orthographic", [](RenderConfig& c) { c.ortho = true; },
         [](RenderConfig& c) { c.zoom = 2; }},
        {"aov", nothing, [](RenderConfig& c) { c.aov = {"normal"}; }},
        {"antialias", nothing, [](RenderConfig& c) { c.antialias = true; }},
        {"supersample", nothing, [](RenderConfig& c) { c.supersample = 2; }},
        {"range", mean, [](RenderConfig& c) { c.range = {"7"}; }},
        {"range of an aov", mean, [](RenderConfig& c) { c.range = {"mean=7"}; }},
        {"legend", mean, [](RenderConfig& c) { c.legend = false; }},
        {"legend_room", nothing, [](RenderConfig& c) { c.legend_room = true, c.size = "500x500"; }},
        {"light_maps", mean, [](RenderConfig& c) { c.light_maps = true; }},
        {"background", nothing, [](RenderConfig& c) { c.background = "black"; }},
        {"unit", mean, [](RenderConfig& c) { c.unit = "mm"; }},
        {"truth_shape", shape, [](RenderConfig& c) { c.truth_shape = "ellipsoid"; }},
        {"offset", shape, [](RenderConfig& c) { c.offset = {0, 0, 0.05}; }},
    };
    expect_each_changes(config("before.png"), cases);
}

TEST_F(RenderStage, PercentileSetsTheRange) {
    write_model(file("m.slim"), test::torus_model(1, 0.35, 60, 24, 2), "{}");
    RenderConfig c = config("x.png");
    c.aov = {"mean"};
    const auto all = run(c);
    c.percentile = 30;
    const auto few = run(c);
    EXPECT_GT(all["ranges"]["mean"][1].get<double>(), few["ranges"]["mean"][1].get<double>());
    EXPECT_EQ(all["ranges"]["mean"][0].get<double>(), -all["ranges"]["mean"][1].get<double>());
}

TEST_F(RenderStage, LodDrawsStandInsForSmallBalls) {
    write_model(file("m.slim"), test::two_level_sphere(1, 150, 3000), "{}");
    RenderConfig c = config("x.png");
    c.lod = 0;
    const auto leaves = run(c);
    c.lod = 40;
    const auto coarse = run(c);
    EXPECT_LT(coarse["surfels_drawn"].get<int>(), leaves["surfels_drawn"].get<int>() / 4);
}

TEST_F(RenderStage, LooseSurfelsAreDrawnOnlyIfAsked) {
    auto model = test::sphere_model(1, 600);
    for (std::size_t i = 1; i < model.nodes.size(); i += 2) model.nodes[i].flags |= kLoose;
    write_model(file("m.slim"), model, "{}");
    RenderConfig c = config("x.png");
    c.lod = 0;
    for (const char* mode : {"forward", "brute"}) {
        c.mode = mode;
        c.loose = false;
        const auto without = run(c);
        EXPECT_EQ(without["loose_hidden"], 300) << mode;
        EXPECT_EQ(without["surfels_drawn"], 300) << mode;
        c.loose = true;
        const auto with = run(c);
        EXPECT_EQ(with["loose_hidden"], 0) << mode;
        EXPECT_EQ(with["surfels_drawn"], 600) << mode;
    }
}

TEST_F(RenderStage, AViewOfNothingButLooseSurfelsSaysSo) {
    auto model = test::sphere_model(1, 600);
    for (std::size_t i = 1; i < model.nodes.size(); ++i) model.nodes[i].flags |= kLoose;
    write_model(file("m.slim"), model, "{}");
    try {
        run(config("x.png"));
        FAIL();
    } catch (const NumericalError& e) {
        EXPECT_NE(std::string(e.what()).find("--loose draws"), std::string::npos) << e.what();
    }
}

TEST_F(RenderStage, BruteModeDrawsTheSamePictureByAnotherWay) {
    RenderConfig c = config("x.exr");
    c.aov = {"depth"};
    c.lod = 0;
    const auto fast = run(c);
    const auto fast_z = read_exr(c.output).channels.at("Z").floats;
    c.mode = "brute";
    const auto slow = run(c);
    const auto slow_z = read_exr(c.output).channels.at("Z").floats;
    ASSERT_EQ(fast_z.size(), slow_z.size());
    int n_far = 0;
    for (std::size_t i = 0; i < fast_z.size(); ++i)
        n_far += std::abs(fast_z[i] - slow_z[i]) > 1e-5f;
    EXPECT_LE(n_far, 2);
    EXPECT_NE(fast["distance_tests"], slow["distance_tests"]);
}

TEST_F(RenderStage, OtherPicturesOfAViewInOneFolderLoseNothing) {
    RenderConfig c = config("out");
    c.aov = {"shaded"};
    run(c);
    const std::string shaded = bytes("out/front.shaded.png");
    c.aov = {"mean"};
    run(c);
    EXPECT_EQ(bytes("out/front.shaded.png"), shaded);
    c.aov = {"shaded"};
    EXPECT_FALSE(run(c).contains("up_to_date"));  // one manifest, of the latest
    EXPECT_EQ(bytes("out/front.shaded.png"), shaded);
    EXPECT_TRUE(run(c).contains("up_to_date"));
    c.name = "light";
    run(c);
    c.name = "", c.aov = {"mean"};
    run(c);
    c.name = "light", c.aov = {"shaded"};
    EXPECT_TRUE(run(c).contains("up_to_date"));  // a view of another name has its own
}

TEST_F(RenderStage, RepeatDrawsAgainThoughAllIsUpToDate) {
    RenderConfig c = config("x.png");
    EXPECT_FALSE(run(c).contains("up_to_date"));
    EXPECT_TRUE(run(c).contains("up_to_date"));
    EXPECT_FALSE(run(c, true).contains("up_to_date"));
    c.repeat = 3;
    EXPECT_FALSE(run(c).contains("up_to_date"));
    EXPECT_FALSE(run(c).contains("up_to_date"));
}

TEST_F(RenderStage, SameBytesForAnyNumberOfThreads) {
    std::string expected;
    for (const int n : {1, 2, 7}) {
        const ThreadLimit limit(n);
        RenderConfig c = config("x.exr");
        c.aov = {"all"};
        run(c, true);
        const std::string now = bytes("x.exr") + bytes("x.png");
        if (expected.empty()) expected = now;
        EXPECT_EQ(now, expected) << n;
    }
}

TEST_F(RenderStage, NormalsAndTruthHaveTheirColours) {
    RenderConfig c = config("x.png");
    c.aov = {"normal"};
    const PngImage normals = draw(c);
    EXPECT_NEAR(pixel(normals, 40, 30)[0], 128, 4);  // n = (0, 0, 1) at the middle
    EXPECT_NEAR(pixel(normals, 40, 30)[2], 255, 2);
    c.aov = {"truth_distance"};
    c.truth_shape = "sphere";
    c.offset = {0, 0, -0.5};  // the true sphere lies behind: the model's front is outside it
    c.legend = false;
    const PngImage distance = draw(c);
    EXPECT_GT(pixel(distance, 40, 30)[0], pixel(distance, 40, 30)[2] + 60);  // warm
    EXPECT_EQ(pixel(distance, 0, 0)[0], 255);  // no hit: background, not a value
}

TEST_F(RenderStage, TransparentBackgroundHasAlpha) {
    RenderConfig c = config("x.png");
    c.background = "transparent";
    const PngImage image = draw(c);
    EXPECT_EQ(image.n_file_channels, 4);
    EXPECT_EQ(pixel(image, 0, 0)[3], 0);
    EXPECT_EQ(pixel(image, 40, 30)[3], 255);
    c.background = "#102030,#405060";
    const PngImage blue = draw(c);
    EXPECT_NEAR(pixel(blue, 0, 0)[0], 0x10, 2);
    EXPECT_NEAR(pixel(blue, 0, 59)[2], 0x60, 2);
}

TEST_F(RenderStage, WorldCamerasSeeAGeoreferencedModel) {
    SurfelTreeData data = test::sphere_model(1, 600);
    data.header.origin = {403000, 3604900, 1000};
    write_model(file("m.slim"), data, "{}");
    RenderConfig c = config("x.png");
    c.camera = "403000,3604900,1005,403000,3604900,1000,0,1,0";
    c.aov = {"truth_distance"};
    c.truth_shape = "sphere";
    c.offset = {403000, 3604900, 1000};
    const auto result = run(c);
    EXPECT_GT(result["covered_pixels"].get<int>(), 300);
    EXPECT_LT(result["ranges"]["truth_distance"][1].get<double>(), 0.02);
}

// As slim measure does: distances to a shape that is nowhere near say nothing.
TEST_F(RenderStage, ATruthFarFromTheModelIsRefused) {
    RenderConfig c = config("x.png");
    c.aov = {"truth_distance"}, c.truth_shape = "sphere";
    c.offset = {500000, 4e6, 100};
    try {
        run(c);
        FAIL();
    } catch (const NumericalError& e) {
        EXPECT_NE(std::string(e.what()).find("--offset"), std::string::npos) << e.what();
    }
    EXPECT_FALSE(exists("x.png"));
    c.offset = {0, 0, 30};  // within ten diagonals
    EXPECT_NO_THROW(run(c));
    c.offset = {0, 0, 40};
    EXPECT_THROW(run(c), NumericalError);
}

TEST_F(RenderStage, APictureWithoutAHitIsANumericalFailure) {
    RenderConfig c = config("x.png");
    c.camera = "0,0,5,0,0,9,0,1,0";
    try {
        run(c);
        FAIL();
    } catch (const NumericalError& e) {
        const std::string text = e.what();
        EXPECT_NE(text.find("eye 0,0,5"), std::string::npos) << text;
        EXPECT_NE(text.find("model from ("), std::string::npos) << text;
        EXPECT_EQ(e.code(), ExitCode::numerical);
    }
    EXPECT_FALSE(exists("x.png"));
}

TEST_F(RenderStage, BadOptionsAreNamed) {
    const RefusedCase cases[] = {
        {"size", [](RenderConfig& c) { c.size = "80"; }},
        {"size", [](RenderConfig& c) { c.size = "0x60"; }},
        {"camera", [](RenderConfig& c) { c.camera = "fornt"; }},
        {"camera", [](RenderConfig& c) { c.camera = "0,0,5,0,0,5,0,1,0"; }},
        {"background", [](RenderConfig& c) { c.background = "#12"; }},
        {"range", [](RenderConfig& c) { c.range = {"-1"}; }},
        {"range", [](RenderConfig& c) { c.range = {"colour=3"}; }},
        {"range", [](RenderConfig& c) { c.range = {"mean=3:1"}; }},
        {"to measure against", [](RenderConfig& c) { c.aov = {"truth_distance"}; }},
        {"truth_shape", [](RenderConfig& c) { c.truth_shape = "sphere"; }},
        {"offset", [](RenderConfig& c) {
             c.aov = {"truth_distance"}, c.truth_shape = "sphere", c.offset = {1, 2};
         }},
    };
    expect_each_is_refused(config("x.png"), cases);
}

TEST_F(RenderStage, OnlyWhatTheAovsNeedIsRendered) {
    EXPECT_EQ(channels_of({"shaded"}, false), kNormalChannel);
    EXPECT_EQ(channels_of({"mean", "k1"}, false), kMeanChannel | kK1Channel);
    EXPECT_EQ(channels_of({"gauss"}, true), kGaussChannel | kMeanChannel | kNormalChannel);  // its range
    EXPECT_EQ(channels_of({"id", "depth"}, true), kSurfelIdChannel | kDepthChannel);
}

}  // namespace
}  // namespace slim
