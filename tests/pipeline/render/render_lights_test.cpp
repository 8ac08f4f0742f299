#include "pipeline/render/render_lights.h"
#include "slim/base/error.h"
#include "tests/pipeline/render/render_test_support.h"
#include "tests/pipeline/render/render_trace_support.h"

#include <gtest/gtest.h>

namespace slim {
namespace {

using test::RenderTrace;

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

TEST_F(RenderTrace, ALightMayStandAtTheWorldsOrigin) {
    write("m.slim", 1, {10, 0, 0});
    RenderConfig c = traced("x.png");
    c.light = "point at=0,0,0";
    EXPECT_NO_THROW(run(c));
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

// Half the shortest side of the box is the least distance that power is measured at; outside the
// box nothing is nearer to its middle.
TEST(Lights, ALampInsideARoomIsAsBrightAtItsWallsAsOneOutsideInTheMiddle) {
    const LightSetting room{{}, {{-3, -2, -1.5}, {3, 2, 1.5}}, {3, 2, 1.5}, {0, 0, 1}};
    const auto reference = [&](const char* text) { return parse_lights(text, room)[0].reference; };
    EXPECT_EQ(reference("point at=3,2,1.5"), 1.5);
    EXPECT_EQ(reference("point at=3,2,2"), 1.5);
    EXPECT_EQ(reference("spot at=3,2,2.5 cone=90"), 1.5);
    EXPECT_EQ(reference("point at=3,2,4"), 2.5);
    EXPECT_EQ(reference("point at=0.5,2,1.5"), 2.5);
    // What they are told to shine at is taken at its word.
    EXPECT_EQ(reference("point at=3,2,1.5 to=3,2,1"), 0.5);
    EXPECT_EQ(parse_lights("point at=3,2,1.5", room)[0].toward, (Vec3d{0, 1, 0}));
    // Which way would they shine?
    for (const char* text : {"spot at=3,2,1.5", "point at=3,2,1 to=3,2,1"})
        EXPECT_THROW(parse_lights(text, room), ConfigError) << text;
}

}  // namespace
}  // namespace slim
