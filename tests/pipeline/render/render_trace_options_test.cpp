#include "tests/pipeline/render/render_trace_support.h"

#include <gtest/gtest.h>

#include <functional>

namespace slim {
namespace {

using test::RenderTrace;

/// The change to a light.
std::function<void(RenderConfig&)> lit(const char* light) {
    return [light](RenderConfig& c) { c.light = light; };
}

void nothing(RenderConfig&) {}
void stood(RenderConfig& c) { c.ground = true, c.zoom = 0.6; }

// Whatever an option is called: a picture that ignores it fails here.
TEST_F(RenderTrace, EveryWordOfALightChangesThePicture) {
    const OptionCase cases[] = {
        {"light", nothing, lit("sun")},
        {"several lights", lit("sun"), lit("sun; key")},
        {"azimuth", lit("sun"), lit("sun azimuth=90")},
        {"elevation", lit("sun"), lit("sun elevation=10")},
        {"from", lit("sun"), lit("sun from=1,2,3")},
        {"power", lit("sun"), lit("sun power=0.5")},
        {"color", lit("sun"), lit("sun color=#ff8000")},
        {"angle", [](RenderConfig& c) { stood(c), c.light = "sun"; }, lit("sun angle=20")},
        {"samples", [](RenderConfig& c) { stood(c), c.light = "sun angle=20"; },
         lit("sun angle=20 samples=64")},
        {"shadows=off", [](RenderConfig& c) { stood(c), c.light = "sun"; },
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
    };
    expect_each_changes(traced("before.png"), cases);
}

TEST_F(RenderTrace, EveryOptionChangesThePicture) {
    write("other.slim", 0.5, {1.2, 0, 0});
    const auto open = [](RenderConfig& c) { c.ground = true, c.ao = true; };
    const auto open_only = [](RenderConfig& c) { c.aov = {"ao"}, c.ground = true; };
    // Two balls, each a mirror.
    const auto mirrors = [&](RenderConfig& c) {
        c.material = "mirror=1", c.add = {file("other.slim")};
    };
    const OptionCase cases[] = {
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
        {"antialias", stood, [](RenderConfig& c) { c.antialias = true; }},
        {"supersample", stood, [](RenderConfig& c) { c.supersample = 2; }},
    };
    expect_each_changes(traced("before.png"), cases);
}

TEST_F(RenderTrace, BadLightsAreNamed) {
    const RefusedCase cases[] = {
        {"did you mean 'spot'", lit("spott at=1,2,3")},
        {"did you mean 'elevation'", lit("sun elevatoin=3")},
        {"at=x,y,z", lit("point")},
        {"elsewhere", lit("point at=0,0,0 to=0,0,0")},
        {"at: expected 3 numbers", lit("point at=1,2")},
        {"at: expected 3 numbers", lit("point at=inf,0,0")},
        {"size: expected 2 numbers", lit("rect at=1,2,3 size=inf,1")},
        {"a sun shines from farther", lit("point at=1e30,0,0")},
        {"power", lit("key power=-1")},
        {"#rrggbb", lit("key color=blue")},
        {"on or off", lit("key shadows=maybe")},
        {"given twice", lit("key power=1 power=2")},
        {"key=value", lit("key 3")},
    };
    expect_each_is_refused(traced("x.png"), cases);
}

TEST_F(RenderTrace, BadOptionsAreNamed) {
    const RefusedCase cases[] = {
        {"ao needs rays", [](RenderConfig& c) { c.mode = "forward", c.ao = true; }},
        {"ground needs rays", [](RenderConfig& c) { c.mode = "forward", c.ground = true; }},
        {"aov ao needs rays", [](RenderConfig& c) { c.mode = "forward", c.aov = {"ao"}; }},
        {"material mirror needs rays",
         [](RenderConfig& c) { c.mode = "forward", c.material = "mirror=1"; }},
        {" raytrace", [](RenderConfig& c) { c.mode = "brute", c.add = {"x.slim"}; }},
        // All that is asked for, at once.
        {"ground", [](RenderConfig& c) { c.mode = "forward", c.ao = c.ground = true; }},
        {" need rays", [](RenderConfig& c) { c.mode = "brute", c.ao = c.ground = true; }},
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
        {"aov color", [&](RenderConfig& c) { c.add = {file("m.slim")}, c.aov = {"color"}; }},
        {"material", [](RenderConfig& c) { c.material = "mirror=2"; }},
        {"at most one", [](RenderConfig& c) { c.material = "mirror=0; mirror=0"; }},
    };
    expect_each_is_refused(traced("x.png"), cases);
}

}  // namespace
}  // namespace slim
