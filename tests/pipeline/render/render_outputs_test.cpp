#include "pipeline/render/render_directions.h"
#include "raytrace/scale_bar.h"
#include "slim/base/error.h"
#include "tests/pipeline/render/render_outputs_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace slim {
namespace {

using test::RenderOutputs;

TEST_F(RenderOutputs, PrincipalDirectionsOfATorusRunAlongTubeAndRing) {
    write_torus(2);
    RenderConfig c = config("x.exr");
    c.aov = {"dir1", "dir2", "position", "normal"}, c.camera = "0,0,4,0,0,0,0,1,0";
    const ExrImage image = data_of(c);
    const auto at = [&](const char* layer, std::size_t i) {
        return Vec3d{image.channels.at(std::string(layer) + ".X").floats[i],
                     image.channels.at(std::string(layer) + ".Y").floats[i],
                     image.channels.at(std::string(layer) + ".Z").floats[i]};
    };
    int n = 0;
    for (std::size_t i = 0; i < 80 * 60; ++i) {
        const Vec3d p = at("P", i), t1 = at("dir1", i), t2 = at("dir2", i);
        if (length(p) == 0 || at("N", i).z < 0.4) continue;
        const Vec3d ring = normalized(Vec3d{-p.y, p.x, 0});
        EXPECT_NEAR(length(t1), 1, 1e-5);
        EXPECT_LT(std::abs(dot(t1, ring)), 0.06);  // k1 = 1/r is across the ring
        EXPECT_GT(std::abs(dot(t2, ring)), 0.99);
        ++n;
    }
    EXPECT_GT(n, 500);
}

// On a sphere rounding says which way curvatures go: of no direction there is no derivative.
TEST_F(RenderOutputs, WhereThereAreNoDirectionsTheirDerivativesAreZeroInEveryMode) {
    write_model(file("m.slim"), test::sphere_model(1, 600, 3), "{}");
    for (const char* mode : {"forward", "raytrace", "brute"}) {
        RenderConfig c = config("x.exr");
        c.mode = mode, c.aov = {"dir1", "e1", "e2", "dk1_dt2", "dk2_dt1"};
        const ExrImage both = data_of(c);
        int n_none = 0;
        for (std::size_t i = 0; i < 80 * 60; ++i) {
            const auto of = [&](const char* name) { return both.channels.at(name).floats[i]; };
            if (of("dir1.X") != 0 || of("dir1.Y") != 0 || of("dir1.Z") != 0) continue;
            for (const char* name : {"extremality.e1", "extremality.e2", "extremality.dk1_dt2",
                                     "extremality.dk2_dt1"})
                ASSERT_EQ(of(name), 0) << mode << ' ' << name;
            n_none += both.channels.at("A").floats[i] > 0 ? 1 : 0;
        }
        EXPECT_GT(n_none, 500) << mode;
        c.output = file("y.exr"), c.aov = {"e1", "e2", "dk1_dt2", "dk2_dt1"};
        const ExrImage alone = data_of(c);
        EXPECT_EQ(alone.channels.at("extremality.e1").floats,
                  both.channels.at("extremality.e1").floats)
            << mode;
    }
}

TEST_F(RenderOutputs, Row43UmbilicAndFlatPixelsHaveNoDirection) {
    GBuffer b;
    b.reset(3, 1,
            kDirectionChannel | kThirdOrderChannel | kK1Channel | kK2Channel | kNormalChannel);
    b.k1 = {2.0f, 2.0f, 1e-4f}, b.k2 = {1.99f, 1.0f, -1e-4f};
    b.hit = {1, 1, 1}, b.direction[0] = {1, 1, 1}, b.normal[2] = {1, 1, 1};
    for (auto& plane : b.third) plane = {3, 3, 3};
    drop_undefined_directions(1, b);
    EXPECT_EQ(b.direction[0], (std::vector<float>{0, 1, 0}));
    for (const auto& plane : b.third) EXPECT_EQ(plane, (std::vector<float>{0, 3, 0}));
    EXPECT_EQ(second_directions(b)[1], (std::vector<float>{0, 1, 0}));
    const Picture picture = paint_directions(b, 1, false, {0, 1});
    EXPECT_EQ(picture.pixel(0, 0)[0], picture.pixel(0, 0)[2]);  // grey
    EXPECT_GT(picture.pixel(1, 0)[0], 0.99f);                   // |x| is red
    EXPECT_EQ(picture.pixel(2, 0)[0], picture.pixel(0, 0)[0]);
}

// NUMERICS 6, row 12: on a torus e1 = e2 = 0 and dk2/dt1 = -R sin b / (r (R + r cos b)^2).
TEST_F(RenderOutputs, DerivativesOfCurvatureOfATorusAreThoseOfTheTorus) {
    write_model(file("m.slim"), test::torus_model(1, 0.35, 120, 48, 3), "{}");
    RenderConfig c = config("x.exr");
    c.aov = {"dk2_dt1", "e1", "e2", "position", "normal"}, c.camera = "0,0,4,0,0,0,0,1,0";
    const ExrImage image = data_of(c);
    double sum = 0, sum_exact = 0, sum_e2 = 0;
    int n = 0;
    for (std::size_t i = 0; i < 80 * 60; ++i) {
        const double x = image.channels.at("P.X").floats[i], y = image.channels.at("P.Y").floats[i];
        const double z = image.channels.at("P.Z").floats[i], ring = std::hypot(x, y);
        if (ring == 0 || image.channels.at("N.Z").floats[i] < 0.5f) continue;
        const double b = std::atan2(z, ring - 1);
        const double exact = std::abs(std::sin(b) / (0.35 * ring * ring));
        sum += std::abs(
            std::abs(static_cast<double>(image.channels.at("extremality.dk2_dt1").floats[i])) -
            exact);
        sum_e2 += std::abs(static_cast<double>(image.channels.at("extremality.e2").floats[i]));
        sum_exact += exact, ++n;
    }
    EXPECT_GT(n, 400);
    EXPECT_LT(sum / sum_exact, 0.2);
    EXPECT_LT(sum_e2 / sum_exact, 0.1);
}

TEST_F(RenderOutputs, DerivativesOfCurvatureWantACubicModelAndSayHowToGetOne) {
    RenderConfig c = config("x.png");
    c.aov = {"shaded", "e1"};
    EXPECT_NE(error_of(c).find("--degree 3"), std::string::npos) << error_of(c);
    c.aov = {"all"};
    const auto result = run(c);  // without them
    for (const auto& each : result["files"])
        EXPECT_EQ(each.get<std::string>().find(".e1."), std::string::npos);
    write_torus(3);
    c.aov = {"e1", "dk1_dt2"}, c.size = "500x400";
    run(c, true);
    EXPECT_NE(bytes("x.e1.legend.svg").find("|e1| = |dk1/dt1|"), std::string::npos);
    EXPECT_NE(bytes("x.e1.legend.svg").find("sign goes with t1"), std::string::npos);
    EXPECT_NE(bytes("x.e1.legend.svg").find("1/model unit\u00b2"), std::string::npos);
}

// The preview's range is of one AOV; what other channels ask of the whole picture needs its own.
TEST_F(RenderOutputs, DataFilesTakeReliefAndTruthBehindAnyPreview) {
    RenderConfig c = config("x.exr");
    c.aov = {"mean", "hillshade", "truth_distance"}, c.truth_shape = "sphere";
    run(c);
    const auto relief = read_exr(c.output).channels;
    c.output = file("y.exr"), c.aov = {"hillshade", "mean", "truth_distance"};
    run(c);
    EXPECT_EQ(relief.at("R").floats, read_exr(c.output).channels.at("R").floats);
}

TEST_F(RenderOutputs, AnInputIsNotWrittenOver) {
    RenderConfig c = config("x.png");
    c.aov = {"matcap"};
    run(c);
    const std::string ball = bytes("x.png");
    c.matcap = c.output;
    EXPECT_THROW(run(c), ConfigError);
    EXPECT_EQ(bytes("x.png"), ball);
}

TEST_F(RenderOutputs, TheFirstPictureOfLightIsUnprefixed) {
    RenderConfig c = config("x.exr");
    c.aov = {"matcap", "shaded"};
    const ExrImage image = data_of(c);
    EXPECT_TRUE(image.channels.contains("R"));
    EXPECT_TRUE(image.channels.contains("shaded.R"));
    EXPECT_FALSE(image.channels.contains("matcap.R"));
}

TEST_F(RenderOutputs, AnEnvironmentOfOneColourLightsAllWithIt) {
    const std::vector<float> red(32, 2.0f), none(32, 0.0f);
    const ExrChannel channels[] = {{"R", ChannelType::float32, red, {}},
                                   {"G", ChannelType::float32, none, {}},
                                   {"B", ChannelType::float32, none, {}}};
    write_exr(file("red.exr"), 8, 4, channels);
    RenderConfig c = config("x.exr");
    c.aov = {"environment"}, c.environment = file("red.exr");
    const ExrImage image = data_of(c);
    const std::size_t middle = 30 * 80 + 40;
    EXPECT_GT(image.channels.at("R").floats[middle], 0.5f);
    EXPECT_EQ(image.channels.at("G").floats[middle], 0.0f);
    // Behind the model, if asked.
    c.output = file("x.png"), c.environment_behind = true;
    const PngImage behind = draw(c);
    EXPECT_GT(behind.rgba[0], 200);
    EXPECT_EQ(behind.rgba[1], 0);
}

TEST_F(RenderOutputs, MatcapsAreReadFromPictures) {
    std::vector<std::uint8_t> rgba;
    for (int i = 0; i < 16 * 16; ++i) rgba.insert(rgba.end(), {10, 200, 30, 255});
    write_png_srgb8(file("ball.png"), 16, 16, rgba);
    RenderConfig c = config("x.png");
    c.aov = {"matcap"}, c.matcap = file("ball.png");
    const PngImage image = draw(c);
    const std::uint8_t* middle = &image.rgba[4 * (30 * 80 + 40)];
    EXPECT_NEAR(middle[0], 10, 1);
    EXPECT_NEAR(middle[1], 200, 1);
    EXPECT_NEAR(middle[2], 30, 1);
}

TEST_F(RenderOutputs, WhereOneFileCannotBeWrittenNoneOfThePictureAppears) {
    write_torus(3);
    std::filesystem::create_directory(file("x.mean.legend.svg"));
    RenderConfig c = config("x.png");
    c.aov = {"shaded", "mean"}, c.lines = {"contour"}, c.lines_ply = file("l.ply"),
    c.size = "300x240";
    EXPECT_THROW(run(c), IoError);
    c.output = file("x.exr"), c.aov = {"mean"};
    EXPECT_THROW(run(c), IoError);
    int n = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder_))
        n += entry.path().extension() != ".slim";
    EXPECT_EQ(n, 1);  // the folder
    std::filesystem::remove(file("x.mean.legend.svg"));
    run(c);
    for (const char* name : {"x.exr", "x.png", "x.lines.svg", "l.ply", "x.mean.legend.svg"})
        EXPECT_TRUE(exists(name)) << name;
}

TEST_F(RenderOutputs, OrthographicPicturesSayTheSizeOfAPixel) {
    RenderConfig c = config("x.png");
    c.ortho_width = 8;
    EXPECT_DOUBLE_EQ(run(c)["pixel_size"].get<double>(), 0.1);
    c.ortho_width = 0;
    EXPECT_FALSE(run(c, true).contains("pixel_size"));
}

TEST_F(RenderOutputs, AScaleBarHasRoomBelowTheObject) {
    RenderConfig c = config("x.png");
    c.size = "400x400", c.ortho = true, c.scale_bar = true, c.background = "transparent",
    c.legend = false;
    const PngImage picture = draw(c);
    const int first = static_cast<int>((1 - scale_bar_share(400, 400)) * 400);
    std::size_t above = 0;
    for (int y = 0; y < 400; ++y)
        for (int x = 240; x < 400; ++x) {  // beside the panel
            const auto alpha = picture.rgba[4 * static_cast<std::size_t>(400 * y + x) + 3];
            if (y >= first) {
                ASSERT_EQ(alpha, 0) << x << ' ' << y;
            }
            above += alpha > 0;
        }
    EXPECT_GT(above, 5000u);
}

}  // namespace
}  // namespace slim
