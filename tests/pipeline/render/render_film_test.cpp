#include "slim/base/error.h"
#include "tests/pipeline/render/render_outputs_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace slim {
namespace {

using test::RenderOutputs;

TEST_F(RenderOutputs, AFilmThatShowsNothingLeavesNoPicture) {
    write_torus(2);
    RenderConfig c = config("film.png");
    c.aov = {"mean"}, c.lines = {"contour"}, c.path = "0,0,50,0,0,90,0,1,0;0,0,60,0,0,90,0,1,0",
    c.frames = 3;
    EXPECT_THROW(run(c), NumericalError);
    int n = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder_))
        n += entry.path().extension() != ".slim";
    EXPECT_EQ(n, 0);
    c.path = "0,0,50,0,0,90,0,1,0;front";  // the last one shows something
    run(c);
    for (const char* name :
         {"film_0001.png", "film_0003.png", "film_0001.lines.svg", "film.mean.legend.svg"})
        EXPECT_TRUE(exists(name)) << name;
}

TEST_F(RenderOutputs, ATurntableIsNumberedAndKeepsItsRange) {
    write_torus(2);
    RenderConfig c = config("film.png");
    c.aov = {"shaded", "mean"}, c.turntable = 4, c.size = "300x240";
    const auto result = run(c);
    EXPECT_EQ(result["frames"], 4);
    EXPECT_EQ(result["film_commands"].size(), 2u);
    EXPECT_NE(result["film_commands"][1].get<std::string>().find("film.mean_%04d.png"),
              std::string::npos);
    for (const char* name : {"film.shaded_0001.png", "film.mean_0004.png", "film.mean.legend.svg"})
        EXPECT_TRUE(exists(name)) << name;
    const auto range = [&](int k) {
        return read_png(file("film.mean_000" + std::to_string(k) + ".png"))
            .metadata.at("slim:range.mean");
    };
    EXPECT_EQ(range(1), range(3));
    EXPECT_NE(bytes("film.shaded_0001.png"), bytes("film.shaded_0002.png"));
    // Lines are numbered alike, however the picture is named.
    c.aov = {"mean"}, c.lines = {"contour"}, c.turntable = 2, c.output = file("lined.mean.png");
    run(c);
    EXPECT_TRUE(exists("lined_0002.lines.svg"));
    EXPECT_TRUE(exists("lined.mean_0002.png"));
    c = config("film.png");
    c.aov = {"shaded", "mean"}, c.turntable = 4, c.size = "300x240";
    // One picture of an array job is that of the film.
    const std::string second = bytes("film.shaded_0002.png");
    const std::string camera = read_png(file("film.shaded_0002.png")).metadata.at("slim:camera");
    c.frame = 2, c.output = file("one.png");
    run(c);
    EXPECT_EQ(read_png(file("one.shaded_0002.png")).metadata.at("slim:camera"), camera);
    EXPECT_EQ(read_png(file("one.shaded_0002.png")).rgba,
              read_png(file("film.shaded_0002.png")).rgba);
    EXPECT_FALSE(exists("one.shaded_0001.png"));
}

TEST_F(RenderOutputs, APathGoesFromItsFirstKeyframeToItsLast) {
    RenderConfig c = config("path.png");
    c.path = "front; right zoom 2", c.frames = 3;
    run(c);
    RenderConfig still = config("still.png");
    EXPECT_EQ(read_png(file("path_0001.png")).rgba, draw(still).rgba);
    still.camera = "right", still.zoom = 2;
    const auto last = draw(still).rgba, along = read_png(file("path_0003.png")).rgba;
    std::size_t n_far = 0;
    for (std::size_t i = 0; i < last.size(); ++i) n_far += std::abs(last[i] - along[i]) > 8;
    EXPECT_LT(n_far, 40u);
}

}  // namespace
}  // namespace slim
