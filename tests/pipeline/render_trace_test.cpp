#include "pipeline/ray_options.h"
#include "pipeline/render_lights.h"
#include "slim/base/error.h"
#include "slim/base/parallel.h"
#include "tests/pipeline/render_test_support.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <functional>
#include <utility>

namespace slim {
namespace {

class RenderTrace : public test::RenderTest {
protected:
    RenderTrace() { write("m.slim", 1, {}); }

    /// A sphere model with the fit errors of a good fit.
    void write(const std::string& name, double radius, const Vec3d& origin) const {
        auto model = test::sphere_model(radius, 600);
        model.header.origin = origin;
        for (TreeNode& node : model.nodes) node.fit_error = 1e-4f;
        write_model(file(name), model, "{}");
    }

    RenderConfig traced(const std::string& output) const {
        RenderConfig c = config(output);
        c.mode = "raytrace";
        return c;
    }
};

// Whatever an option is called: a picture that ignores it fails here.
TEST_F(RenderTrace, EveryOptionChangesThePicture) {
    write("other.slim", 0.5, {1.2, 0, 0});
    const auto nothing = [](RenderConfig&) {};
    const auto lit = [](const char* light) {
        return [light](RenderConfig& c) { c.light = light; };
    };
    const auto stood = [](RenderConfig& c) { c.ground = true, c.zoom = 0.6; };
    const auto open = [](RenderConfig& c) { c.ground = true, c.ao = true; };
    const auto open_only = [](RenderConfig& c) { c.aov = {"ao"}, c.ground = true; };
    // Two balls, each a mirror.
    const auto mirrors = [&](RenderConfig& c) {
        c.material = "mirror=1", c.add = {file("other.slim")};
    };
    const OptionCase cases[] = {
        {"light", nothing, lit("sun")},
        {"several lights", lit("sun"), lit("sun; key")},
        {"azimuth", lit("sun"), lit("sun azimuth=90")},
        {"elevation", lit("sun"), lit("sun elevation=10")},
        {"from", lit("sun"), lit("sun from=1,2,3")},
        {"power", lit("sun"), lit("sun power=0.5")},
        {"color", lit("sun"), lit("sun color=#ff8000")},
        {"angle", [&](RenderConfig& c) { stood(c), c.light = "sun"; }, lit("sun angle=20")},
        {"samples", [&](RenderConfig& c) { stood(c), c.light = "sun angle=20"; },
         lit("sun angle=20 samples=64")},
        {"shadows=off", [&](RenderConfig& c) { stood(c), c.light = "sun"; },
         lit("sun shadows=off")},
        {"point", lit("sun"), lit("point at=2,3,4")},
        {"at", lit("point at=2,3,4"), lit("point at=3,3,4")},
        {"spot", lit("point at=2,3,4"), lit("spot at=2,3,4 cone=10")},
        {"to", lit("spot at=2,3,4 cone=10"), lit("spot at=2,3,4 cone=10 to=1,0,0")},
        {"cone", lit("spot at=2,3,4 cone=10"), lit("spot at=2,3,4 cone=15")},
        {"blur", lit("spot at=2,3,4 cone=10"), lit("spot at=2,3,4 cone=10 blur=1")},
        {"rect", lit("point at=2,3,4"), lit("rect at=2,3,4 size=2,2")},
        {"size", lit("rect at=2,3,4 size=2,2"), lit("rect at=2,3,4 size=2,1")},
        {"disc", lit("rect at=2,3,4 size=2,2"), lit("disc at=2,3,4 size=2")},
        {"ambient", nothing, [](RenderConfig& c) { c.ambient = 0.3; }},
        {"material color", nothing, [](RenderConfig& c) { c.material = "color=#804020"; }},
        {"material specular", nothing, [](RenderConfig& c) { c.material = "specular=0.5"; }},
        {"material shininess", nothing, [](RenderConfig& c) { c.material = "shininess=4"; }},
        {"material mirror", nothing, [](RenderConfig& c) { c.material = "mirror=0.4"; }},
        {"material of the second model", mirrors,
         [](RenderConfig& c) { c.material = "mirror=1; color=#804020"; }},
        {"shadows", stood, [](RenderConfig& c) { c.shadows = false; }},
        {"bounces", mirrors, [](RenderConfig& c) { c.bounces = 1; }},
        {"ao", [](RenderConfig& c) { c.ground = true; }, [](RenderConfig& c) { c.ao = true; }},
        {"ao_distance", open, [](RenderConfig& c) { c.ao_distance = 5; }},
        {"ao_samples", open, [](RenderConfig& c) { c.ao_samples = 4; }},
        {"ao_distance of the aov", open_only, [](RenderConfig& c) { c.ao_distance = 5; }},
        {"ground", [](RenderConfig& c) { c.zoom = 0.6; }, [](RenderConfig& c) { c.ground = true; }},
        {"ground_height", stood, [](RenderConfig& c) { c.ground_height = "-2"; }},
        {"ground_color", stood, [](RenderConfig& c) { c.ground_color = "#406080"; }},
        {"up", [&](RenderConfig& c) { stood(c), c.camera = "5,4,5,0,0,0,0,1,0"; },
         [](RenderConfig& c) { c.up = "x"; }},
        {"add", nothing, [&](RenderConfig& c) { c.add = {file("other.slim")}; }},
        {"supersample", stood, [](RenderConfig& c) { c.supersample = 2; }},
    };
    expect_each_changes(traced("before.png"), cases);
}

TEST_F(RenderTrace, LightsAndMaterialsWorkInForwardModeToo) {
    RenderConfig c = config("before.png");
    const auto before = draw(c).rgba;
    for (const char* light : {"sun", "point at=2,3,4", "disc at=2,3,4", "key"}) {
        c.light = light;
        EXPECT_NE(draw(c).rgba, before) << light;
    }
    c = config("color.png");
    c.material = "color=#804020";
    EXPECT_NE(draw(c).rgba, before);
    // The default, written otherwise, takes the general way to the same colours.
    c.material = "color=#d8d0c7", c.light = "fill shadows=off; key";
    const auto again = draw(c).rgba;
    for (std::size_t i = 0; i < again.size(); ++i) ASSERT_NEAR(again[i], before[i], 2) << i;
}

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

TEST_F(RenderTrace, BadOptionsAreNamed) {
    const auto light = [](const char* text) { return [text](RenderConfig& c) { c.light = text; }; };
    const std::pair<const char*, std::function<void(RenderConfig&)>> cases[] = {
        {"--mode raytrace", [](RenderConfig& c) { c.mode = "forward", c.ao = true; }},
        {"--mode raytrace", [](RenderConfig& c) { c.mode = "forward", c.ground = true; }},
        {"--mode raytrace", [](RenderConfig& c) { c.mode = "forward", c.aov = {"ao"}; }},
        {"--mode raytrace", [](RenderConfig& c) { c.mode = "forward", c.material = "mirror=1"; }},
        {"--mode raytrace", [](RenderConfig& c) { c.mode = "brute", c.add = {"x.slim"}; }},
        {"--ao", [](RenderConfig& c) { c.ao_distance = 1; }},
        {"--ao", [](RenderConfig& c) { c.ao_samples = 9; }},
        {"ao is for the aov shaded", [](RenderConfig& c) { c.ao = true, c.aov = {"mean"}; }},
        {"ground is for the aov shaded or ao",
         [](RenderConfig& c) { c.ground = true, c.aov = {"mean"}; }},
        {"light is for the aov shaded", [](RenderConfig& c) { c.light = "sun", c.aov = {"ao"}; }},
        {"material is for",
         [](RenderConfig& c) { c.material = "color=#102030", c.aov = {"normal"}; }},
        {"ambient is for", [](RenderConfig& c) { c.ambient = 0.5, c.aov = {"depth"}; }},
        {"--ground", [](RenderConfig& c) { c.ground_height = "1"; }},
        {"--ground", [](RenderConfig& c) { c.ground_color = "#112233"; }},
        {"ground_height", [](RenderConfig& c) { c.ground = true, c.ground_height = "low"; }},
        {"ground_color", [](RenderConfig& c) { c.ground = true, c.ground_color = "red"; }},
        {"did you mean 'spot'", light("spott at=1,2,3")},
        {"did you mean 'elevation'", light("sun elevatoin=3")},
        {"at=x,y,z", light("point")},
        {"elsewhere", light("point at=0,0,0 to=0,0,0")},
        {"at: expected 3 numbers", light("point at=1,2")},
        {"at: expected 3 numbers", light("point at=inf,0,0")},
        {"size: expected 2 numbers", light("rect at=1,2,3 size=inf,1")},
        {"a sun shines from farther", light("point at=1e30,0,0")},
        {"aov color", [&](RenderConfig& c) { c.add = {file("m.slim")}, c.aov = {"color"}; }},
        {"power", light("key power=-1")},
        {"#rrggbb", light("key color=blue")},
        {"on or off", light("key shadows=maybe")},
        {"given twice", light("key power=1 power=2")},
        {"key=value", light("key 3")},
        {"material", [](RenderConfig& c) { c.material = "mirror=2"; }},
        {"at most one", [](RenderConfig& c) { c.material = "mirror=0; mirror=0"; }},
    };
    for (const auto& [word, change] : cases) {
        RenderConfig c = traced("x.png");
        change(c);
        try {
            run(c);
            ADD_FAILURE() << word;
        } catch (const ConfigError& e) {
            EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << e.what();
        }
    }
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

TEST_F(RenderTrace, ALightMayStandAtTheWorldsOrigin) {
    write("m.slim", 1, {10, 0, 0});
    RenderConfig c = traced("x.png");
    c.light = "point at=0,0,0";
    EXPECT_NO_THROW(run(c));
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

// North is where the front view looks; azimuth runs clockwise.
TEST(Lights, TheSunStandsWhereAzimuthAndElevationSay) {
    const auto toward = [](const char* text, const Vec3d& up) {
        return parse_lights(text, {{}, {{-1, -1, -1}, {1, 1, 1}}, {}, up})[0].toward;
    };
    const auto near = [](const Vec3d& a, const Vec3d& b) { EXPECT_LT(length(a - b), 1e-12); };
    near(toward("sun azimuth=0 elevation=0", {0, 0, 1}), {0, 1, 0});
    near(toward("sun azimuth=90 elevation=0", {0, 0, 1}), {1, 0, 0});
    near(toward("sun azimuth=0 elevation=0", {0, 1, 0}), {0, 0, -1});
    near(toward("sun azimuth=90 elevation=0", {0, 1, 0}), {1, 0, 0});
    near(toward("sun elevation=90", {0, 1, 0}), {0, 1, 0});
    near(toward("sun from=0,0,5", {0, 1, 0}), {0, 0, 1});
}

TEST(Lights, PlacesAreInTheWorld) {
    const LightSetting setting{{}, {{-1, -1, -1}, {1, 1, 1}}, {100, 200, 300}, {0, 1, 0}};
    const LightSource light = parse_lights("spot at=100,205,300", setting)[0];
    EXPECT_EQ(light.position, (Vec3d{0, 5, 0}));
    EXPECT_EQ(light.toward, (Vec3d{0, 1, 0}));
    EXPECT_EQ(light.reference, 5);
}

}  // namespace
}  // namespace slim
