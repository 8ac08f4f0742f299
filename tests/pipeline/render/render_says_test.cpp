#include "slim/base/error.h"
#include "tests/pipeline/render/render_outputs_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>

// What a run of slim render says: counts, warnings, refusals.

namespace slim {
namespace {

class RenderSays : public test::RenderOutputs {
protected:
    struct Listener : Reporter {
        void warn(const std::string& text) override { warnings += text + "\n"; }
        std::string warnings;
    };

    std::string warnings_of(const RenderConfig& config) {
        RenderConfig c = config;
        const FieldList fields = fields_of(c);
        Listener listener;
        StageContext context{
            listener, 1, true, "render", canonical_config(fields), print_config(fields), ""};
        run_render(c, context);
        return listener.warnings;
    }
    std::string refusal_of(const RenderConfig& config) {
        try {
            run(config);
            return "";
        } catch (const Error& error) {
            return error.what();
        }
    }
};

bool has(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

TEST_F(RenderSays, CreasesThatAModelHasNotAreWarnedOfWhereACommandAsksForThem) {
    RenderConfig c = config("x.png");
    c.lines = {"crease", "contour"};
    const std::string warnings = warnings_of(c);
    EXPECT_TRUE(has(warnings, "crease lines") && has(warnings, "left out")) << warnings;
    setenv(kErrorsByParent, "1", 1);
    EXPECT_EQ(warnings_of(c), "");  // a style is for scans with and without edges
    unsetenv(kErrorsByParent);
}

TEST_F(RenderSays, NoColourOfADataFileIsInfinite) {
    RenderConfig c = config("x.exr");
    c.light = "sun azimuth=0 elevation=60 power=1e6";
    const std::string warnings = warnings_of(c);
    EXPECT_TRUE(has(warnings, "x.exr: ") && has(warnings, "65504")) << warnings;
    const auto n = run(c, true)["clamped_values"].get<std::uint64_t>();
    std::uint64_t n_largest = 0;
    const ExrImage image = read_exr(c.output);
    for (const char* channel : {"R", "G", "B"})
        for (const float v : image.channels.at(channel).floats) {
            ASSERT_TRUE(std::isfinite(v));
            n_largest += v == kLargestHalf;
        }
    EXPECT_GT(n, 500u);
    EXPECT_GE(n_largest, n);
    c.light = "sun azimuth=0 elevation=60";
    EXPECT_EQ(run(c)["clamped_values"], 0);
    EXPECT_FALSE(has(warnings_of(c), "65504"));
}

TEST_F(RenderSays, WhatAovAllLeavesOut) {
    RenderConfig c = config("x.png");
    c.aov = {"all"};
    const auto left_out = [&] {
        std::string all;
        const auto result = run(c);
        for (const auto& reason : result.value("left_out", nlohmann::json::array()))
            all += reason.get<std::string>() + "\n";
        return all;
    };
    const std::string all = left_out();
    for (const char* aov : {"e1, e2, dk1_dt2, dk2_dt1: ", "color: ", "ao: ", "truth_distance: "})
        EXPECT_TRUE(has(all, aov)) << all;
    c.aov = {"all", "truth_distance"}, c.truth_shape = "sphere";
    EXPECT_TRUE(has(left_out(), "ao: "));
    EXPECT_FALSE(has(left_out(), "truth_distance"));
    c.aov = {"mean"}, c.truth_shape = "";
    EXPECT_EQ(left_out(), "");
}

TEST_F(RenderSays, ThatAModelIsTooSmallToBeSeenBesideAnother) {
    write_model(file("small.slim"), test::sphere_model(0.9e-3, 100), "{}");
    write_model(file("fair.slim"), test::sphere_model(1.2e-3, 100), "{}");
    RenderConfig c = config("x.png");
    c.mode = "raytrace", c.camera = "iso", c.add = {file("fair.slim"), file("small.slim")};
    const std::string warnings = warnings_of(c);
    EXPECT_TRUE(has(warnings, (file("small.slim") + ": " + c.model + " is 11").c_str()) &&
                has(warnings, "unit"))
        << warnings;
    std::swap(c.model, c.add[1]);  // whichever comes first
    EXPECT_TRUE(has(warnings_of(c), (c.model + ": " + c.add[1] + " is 11").c_str()))
        << warnings_of(c);
    std::swap(c.model, c.add[1]);
    c.camera = "0.003,0,2,0.003,0,0,0,1,0";  // whoever says where looks at what is there
    EXPECT_EQ(warnings_of(c), "");
    c.camera = "iso", c.add = {file("fair.slim")};
    EXPECT_EQ(warnings_of(c), "");
}

TEST_F(RenderSays, ThatEveryLightIsBelowTheGround) {
    RenderConfig c = config("x.png");
    c.mode = "raytrace", c.ground = true, c.camera = "0,1.5,5,0,0,0,0,1,0";
    c.light = "point at=0,-3,3; sun azimuth=0 elevation=-20";
    EXPECT_TRUE(has(warnings_of(c), "no shadow falls on it")) << warnings_of(c);
    c.ground_color = "#ffffff";
    EXPECT_TRUE(has(warnings_of(c), "ambient light alone")) << warnings_of(c);
    c.light = "point at=0,-3,3; point at=0,3,3";
    EXPECT_EQ(warnings_of(c), "");
    c.light = "point at=0,-3,3", c.ground_height = "-4";
    EXPECT_EQ(warnings_of(c), "");
}

TEST_F(RenderSays, WhatHadNoRoom) {
    RenderConfig c = config("x.png");
    c.ortho = true, c.scale_bar = true, c.aov = {"mean"}, c.size = "250x250";
    EXPECT_TRUE(has(warnings_of(c), "too small for its legend, which")) << warnings_of(c);
    EXPECT_FALSE(has(warnings_of(c), "scale bar"));
    c.aov = {"shaded"};
    EXPECT_EQ(warnings_of(c), "");
    c.size = "12x12";
    EXPECT_TRUE(has(warnings_of(c), "too small for its scale bar")) << warnings_of(c);
    EXPECT_FALSE(has(warnings_of(c), "legend"));
}

TEST_F(RenderSays, ThePlaceOfAFault) {
    RenderConfig c = config("x.png");
    c.path = "front; frnt zoom 2", c.frames = 3;
    EXPECT_TRUE(has(refusal_of(c), "path: keyframe 2 \"frnt\": expected front")) << refusal_of(c);
    EXPECT_FALSE(has(refusal_of(c), "camera: "));
    c = config("x.png");
    c.aov = {"truth_distance"}, c.truth_shape = "spheer";
    EXPECT_TRUE(has(refusal_of(c), "did you mean 'sphere'?")) << refusal_of(c);
    // A named camera is no remedy where it is used.
    c = config("x.png");
    write_torus(2);
    c.camera = "0,0,9,0,0,99,0,1,0";
    EXPECT_TRUE(has(refusal_of(c), "as --camera iso")) << refusal_of(c);
    c.camera = "top", c.up = "z", c.size = "3x1";  // the middle of the torus is open
    EXPECT_TRUE(has(refusal_of(c), "between the middles of the pixels")) << refusal_of(c);
    EXPECT_FALSE(has(refusal_of(c), "--camera iso")) << refusal_of(c);
    c.size = "80x60", c.zoom = 100;
    EXPECT_TRUE(has(refusal_of(c), "--zoom 100 shows the middle")) << refusal_of(c);
}

TEST_F(RenderSays, HowMuchWasPassedOver) {
    // A sphere hides its far side: of that nothing is tested.
    RenderConfig c = config("x.png");
    c.size = "200x200";
    const auto sphere = run(c);
    EXPECT_GT(sphere["surfels_cut_off"].get<int>(), 100);
    EXPECT_GT(sphere["blocks_passed"].get<int>(), 100);
    // One sheet of discs, far from one another in depth only by rounding, hides nothing.
    std::vector<Surfel> discs;
    for (int i = 0; i < 100; ++i)
        discs.push_back({{0.2 * (i % 10) - 0.9, 0.2 * (i / 10) - 0.9, 0},
                         0.15,
                         frame_from_normal(Vec3d{0, 0, 1}),
                         {},
                         2});
    write_model(file("m.slim"), test::flat_tree(discs, 2), "{}");
    const auto sheet = run(c);
    EXPECT_EQ(sheet["surfels_cut_off"], 0);
    EXPECT_GT(sheet["root_tests"].get<int>(), 1000);
    c.mode = "brute";
    EXPECT_EQ(run(c)["blocks_passed"], 0);
}

TEST_F(RenderSays, HowManyBytesAPixelTakes) {
    RenderConfig c = config("x.png");
    c.aov = {"normal"};
    EXPECT_EQ(run(c)["plane_bytes"], 1 + 3 * 4);
    c.aov = {"normal", "mean"};
    EXPECT_EQ(run(c)["plane_bytes"], 1 + 4 * 4);
    c.aov = {"normal"}, c.lines = {"parabolic"};
    // Normals, and the four of a line: positions, Hessians and what the surfels err by.
    EXPECT_EQ(run(c)["plane_bytes"], 1 + (3 + 3 + 3 + 1) * 4);
}

TEST_F(RenderSays, AnglesOfViewAsTheLibraryTakesThem) {
    RenderConfig c = config("x.png");
    const FieldList fields = fields_of(c);
    EXPECT_NO_THROW(fields.find("fov")->set({"179"}, {.key = "fov"}));
    EXPECT_GT(run(c)["covered_pixels"].get<int>(), 10);
    EXPECT_NO_THROW(fields.find("fov")->set({"0.001"}, {.key = "fov"}));
    EXPECT_GT(run(c)["covered_pixels"].get<int>(), 1000);
    EXPECT_THROW(fields.find("fov")->set({"180"}, {.key = "fov"}), ConfigError);
}

TEST_F(RenderSays, FlatFacesDoNotSetTheRangeOfAPart) {
    // A wide plane of discs and a small ball on it.
    std::vector<Surfel> leaves;
    for (int i = 0; i < 400; ++i)
        leaves.push_back({{0.5 * (i % 20) - 4.75, 0.5 * (i / 20) - 4.75, 0},
                          0.6,
                          frame_from_normal(Vec3d{0, 0, 1}),
                          {},
                          2});
    for (const Surfel& s : test::sphere_leaves(0.8, 300, 6, 2)) leaves.push_back(s);
    write_model(file("m.slim"), test::flat_tree(leaves, 2), "{}");
    RenderConfig c = config("x.png");
    c.aov = {"mean"}, c.size = "300x300";
    const double end = run(c)["ranges"]["mean"][1].get<double>();
    EXPECT_GT(end, 1.0);  // 1 / 0.8 = 1.25
    EXPECT_LT(end, 4.0);
}

}  // namespace
}  // namespace slim
