#include "slim/base/error.h"
#include "slim/base/parallel.h"
#include "tests/pipeline/render/render_test_support.h"
#include "tests/pipeline/render/render_trace_support.h"
#include "tests/raytrace/support/sharp_models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>

namespace slim {
namespace {

using test::RenderTrace;

TEST_F(RenderTrace, DrawsWhatForwardModeDraws) {
    for (const char* aov : {"normal", "mean", "depth", "id", "level"}) {
        RenderConfig c = config("forward.png");
        c.aov = {aov}, c.lod = 0;
        if (c.aov[0] == "mean" || c.aov[0] == "depth") c.range = {"2"};
        const auto forward = draw(c).rgba;
        c.mode = "raytrace", c.output = file("traced.png");
        const auto rays = draw(c).rgba;
        int n = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) n += std::abs(rays[i] - forward[i]) > 1;
        EXPECT_LT(n, 20) << aov;
    }
}

TEST_F(RenderTrace, ThreadsDoNotMatter) {
    RenderConfig c = traced("x.png");
    c.ground = c.ao = true, c.light = "key angle=5; fill; rect at=2,3,4", c.material = "mirror=0.3",
    c.supersample = 2;
    const auto with = [&](int n) {
        const ThreadLimit limit(n);
        run(c, true);
        return bytes("x.png");
    };
    const std::string one = with(1);
    EXPECT_EQ(one, with(2));
    EXPECT_EQ(one, with(7));
}

TEST_F(RenderTrace, TheGroundLiesUnderTheModelAndIsSeenThrough) {
    RenderConfig c = traced("x.png");
    c.ground = true, c.background = "transparent", c.camera = "0,3,6,0,-1,0,0,1,0";
    const PngImage png = draw(c);
    int shadow = 0, clear = 0;
    for (std::size_t i = 0; i < png.rgba.size(); i += 4) {
        const bool black = png.rgba[i] == 0 && png.rgba[i + 1] == 0 && png.rgba[i + 2] == 0;
        shadow += black && png.rgba[i + 3] > 50;
        clear += png.rgba[i + 3] == 0;
    }
    EXPECT_GT(shadow, 100);
    EXPECT_GT(clear, 1000);
}

TEST_F(RenderTrace, TheGroundLiesUnderTheTipsOfSharpModels) {
    SurfelTreeData tree = test::flat_tree(test::cube_leaves(), 2);
    tree.header.origin = {0, 5, 0};
    RenderConfig c = traced("x.png");
    c.ground = true, c.up = "y";
    write_model(file("m.slim"), tree, "{}");
    const double of_centres = run(c)["ground_height"].get<double>();
    // A tip that no surfel has its centre at.
    tree.header.bounds = tree.header.drawn = {{-1, -1.5, -1}, {1, 1, 1}};
    tree.header.hull = {{0, -1.5, 0}, {1, 1, 1}};
    write_model(file("m.slim"), tree, "{}");
    c.output = file("y.png");
    EXPECT_GT(of_centres, 5 - 1.4);
    EXPECT_NEAR(run(c)["ground_height"].get<double>(), 5 - 1.5, 1e-4);
    c.output = file("z.png"), c.ground_height = "2.25";
    EXPECT_EQ(run(c)["ground_height"], 2.25);
}

TEST_F(RenderTrace, ModelsStandWhereTheWorldHasThem) {
    write("m.slim", 1, {1000, 2000, 3000});
    write("other.slim", 1, {1003, 2000, 3000});
    RenderConfig c = traced("x.png");
    c.add = {file("other.slim")}, c.size = "120x60", c.background = "transparent";
    EXPECT_EQ(run(c)["surfels_drawn"], 1200);
    const PngImage png = read_png(c.output);
    // Two balls side by side, the camera's frame about both.
    const auto alpha = [&](int x) {
        return png.rgba[4 * static_cast<std::size_t>(30 * 120 + x) + 3];
    };
    EXPECT_EQ(alpha(60), 0);
    EXPECT_GT(alpha(40), 200);
    EXPECT_GT(alpha(80), 200);
}

TEST_F(RenderTrace, OpennessIsInTheDataFile) {
    RenderConfig c = traced("x.exr");
    c.aov = {"shaded", "ao"};
    run(c);
    EXPECT_NE(bytes("x.exr").find("light.ao"), std::string::npos);
}

TEST_F(RenderTrace, ACropOfFilteredOpennessIsThatPartOfTheWhole) {
    RenderConfig c = traced("x.png");
    c.ao = c.ground = true, c.size = "200x160", c.camera = "iso";
    const PngImage whole = draw(c);
    constexpr int kX = 70, kY = 43, kWidth = 61, kHeight = 50;
    c.crop = "70,43,61,50";
    const PngImage part = draw(c);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            ASSERT_TRUE(std::equal(test::pixel(part, x, y), test::pixel(part, x, y) + 4,
                                   test::pixel(whole, x + kX, y + kY)))
                << x << ' ' << y;
}

TEST_F(RenderTrace, SupersamplingTakesEveryAov) {
    RenderConfig c = traced("x.png");
    c.aov = {"ao", "shaded", "id"}, c.ao = c.ground = true, c.supersample = 2;
    run(c);
    EXPECT_TRUE(exists("x.ao.png") && exists("x.shaded.png") && exists("x.id.png"));
    c.output = file("x.exr");
    run(c);
    EXPECT_TRUE(exists("x.exr"));
}

TEST_F(RenderTrace, AnEmptyPictureIsAnError) {
    RenderConfig c = traced("x.png");
    c.camera = "0,0,5,0,0,9,0,1,0", c.ground = true;
    try {
        run(c);
        ADD_FAILURE();
    } catch (const NumericalError& e) {
        EXPECT_EQ(e.code(), ExitCode::numerical);
    }
    EXPECT_FALSE(exists("x.png"));
}

// Rays go through a tree of all leaves, which is built before anything is drawn.
TEST_F(RenderTrace, ADamagedModelIsRefusedBeforeItsLeavesAreUsed) {
    auto model = test::sphere_model(1, 600);
    model.sharp = {{static_cast<std::uint32_t>(model.nodes.size() - 1)}};
    model.sheets.resize(static_cast<std::size_t>(floats_per_sheet(model.header.degree)));
    write_model(file("m.slim"), model, "{}");
    std::string damaged = bytes("m.slim");
    std::uint64_t chunk = 0;  // the table's entry: name 24, sizes 16, place
    std::memcpy(&chunk, &damaged[damaged.rfind(std::string("sharp\0", 6)) + 40], sizeof chunk);
    damaged.replace(chunk, sizeof(SharpEntry), sizeof(SharpEntry), '\xff');
    std::ofstream(file("m.slim"), std::ios::binary) << damaged;
    EXPECT_THROW(run(traced("x.png")), FormatError);
}

TEST_F(RenderTrace, PositionsOfFurtherModelsHaveColoursOfTheirOwn) {
    write("m.slim", 1, {4, 0, 0});
    write("other.slim", 1, {8, 0, 0});
    RenderConfig c = traced("x.png");
    c.add = {file("other.slim")}, c.aov = {"position"}, c.size = "160x60", c.background = "black";
    const PngImage image = draw(c);
    int full = 0, hits = 0;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
        hits += image.rgba[i] > 0, full += image.rgba[i] == 255;
    }
    EXPECT_GT(hits, 500);
    EXPECT_LT(full, hits / 20);  // half of them if x ended with the first model
}

TEST_F(RenderTrace, LinesAndDirectionsOfAModelDoNotDependOnWhatStandsFirst) {
    const auto torus = [&](const char* name, double size, const Vec3d& origin) {
        auto model = test::torus_model(size, 0.4 * size, 60, 24, 2);
        model.header.origin = origin;
        for (TreeNode& node : model.nodes) node.fit_error = 1e-4f;
        write_model(file(name), model, "{}");
    };
    torus("big.slim", 1, {0, 0, 0}), torus("small.slim", 0.02, {1.6, 0, 0});
    RenderConfig c = traced("x.png");
    c.camera = "1.2,-1.5,3,1.2,0,0", c.aov = {"shaded", "dir1"},
    c.lines = {"contour", "suggestive", "parabolic"};
    c.model = file("big.slim"), c.add = {file("small.slim")};
    const auto one = run(c)["lines"];
    const std::string directions = bytes("x.dir1.png");
    c.model = file("small.slim"), c.add = {file("big.slim")};
    const auto other = run(c)["lines"];
    for (const char* kind : {"contour", "parabolic"}) {
        EXPECT_GT(one[kind]["polylines"].get<int>(), 0) << kind;
        EXPECT_EQ(one[kind]["polylines"], other[kind]["polylines"]) << kind;
        const auto strength = one[kind]["strength"].get<double>();
        EXPECT_NEAR(other[kind]["strength"].get<double>(), strength, 0.01 * strength) << kind;
        EXPECT_NEAR(one[kind]["length"].get<double>(), other[kind]["length"].get<double>(), 0.01)
            << kind;
    }
    int n_far = 0;
    const PngImage a = read_png(file("x.dir1.png"));
    std::ofstream(file("y.png"), std::ios::binary) << directions;
    const PngImage b = read_png(file("y.png"));
    for (std::size_t i = 0; i < a.rgba.size(); ++i) n_far += std::abs(a.rgba[i] - b.rgba[i]) > 8;
    EXPECT_LT(n_far, 100);
}

TEST_F(RenderTrace, AnAddedFileThatIsNoModelIsNamed) {
    RenderConfig c = traced("x.png");
    c.add = {file("missing.slim")};
    EXPECT_THROW(run(c), Error);
}

}  // namespace
}  // namespace slim
