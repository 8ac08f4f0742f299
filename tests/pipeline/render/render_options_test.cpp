#include "slim/base/error.h"
#include "tests/pipeline/render/render_outputs_support.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>

namespace slim {
namespace {

using test::RenderOutputs;

TEST_F(RenderOutputs, OptionsOfPicturesThatNobodyAsksForAndBadOnesAreNamed) {
    std::ofstream(file("words.png")) << "no picture";
    const std::pair<const char*, std::function<void(RenderConfig&)>> cases[] = {
        {"aov environment", [&](RenderConfig& c) { c.environment = file("words.png"); }},
        {"aov environment", [](RenderConfig& c) { c.environment_turn = 3; }},
        {"aov environment", [](RenderConfig& c) { c.environment_behind = true; }},
        {"aov matcap", [&](RenderConfig& c) { c.matcap = file("words.png"); }},
        {"aov hillshade",
         [](RenderConfig& c) {
             c.sun = {10, 10};
         }},
        {"aov hillshade", [](RenderConfig& c) { c.contours = "3"; }},
        {"contours: expected", [](RenderConfig& c) { c.contours = "-3", c.aov = {"hillshade"}; }},
        {"2.3e-308", [](RenderConfig& c) { c.contours = "1e-310", c.aov = {"hillshade"}; }},
        {"sun: expected",
         [](RenderConfig& c) {
             c.sun = {1, 91}, c.aov = {"hillshade"};
         }},
        {"words.png", [&](RenderConfig& c) { c.matcap = file("words.png"), c.aov = {"matcap"}; }},
        {"nowhere.png",
         [&](RenderConfig& c) { c.matcap = file("nowhere.png"), c.aov = {"matcap"}; }},
        {"no one scale", [](RenderConfig& c) { c.scale_bar = true; }},
        {"crop: expected", [](RenderConfig& c) { c.crop = "1,2,3"; }},
        {"inside the picture of 80x60", [](RenderConfig& c) { c.crop = "70,0,11,10"; }},
        {"tile: expected", [](RenderConfig& c) { c.tile = "3/2"; }},
        {"give one", [](RenderConfig& c) { c.tile = "1/2", c.crop = "0,0,1,1"; }},
        {"frames", [](RenderConfig& c) { c.path = "front; back"; }},
        {"frames is for a ", [](RenderConfig& c) { c.frames = 3; }},
        {"give one", [](RenderConfig& c) { c.path = "front", c.frames = 2, c.turntable = 3; }},
        {"expected 1 to 3", [](RenderConfig& c) { c.turntable = 3, c.frame = 4; }},
        {"path: keyframe 2 \"sideways\": expected",
         [](RenderConfig& c) { c.path = "front; sideways", c.frames = 4; }},
        {"zoom", [](RenderConfig& c) { c.path = "front zoom x", c.frames = 4; }},
    };
    for (const auto& [words, change] : cases) {
        RenderConfig c = config("x.png");
        change(c);
        EXPECT_NE(error_of(c).find(words), std::string::npos) << words << ": " << error_of(c);
    }
}

// Whatever an option is called: a picture that ignores it fails here.
TEST_F(RenderOutputs, EveryOptionChangesThePicture) {
    struct Case {
        const char* what;
        std::function<void(RenderConfig&)> before, change;
    };
    const auto light = [](RenderConfig& c) { c.aov = {"environment"}; };
    const auto relief = [](RenderConfig& c) { c.aov = {"hillshade"}, c.size = "400x300"; };
    const Case cases[] = {
        {"environment_turn", light, [](RenderConfig& c) { c.environment_turn = 90; }},
        {"environment_behind", light, [](RenderConfig& c) { c.environment_behind = true; }},
        {"up of light", light, [](RenderConfig& c) { c.up = "-y"; }},
        {"sun", relief,
         [](RenderConfig& c) {
             c.sun = {135, 30};
         }},
        {"contours", relief, [](RenderConfig& c) { c.contours = "none"; }},
        {"contours", relief, [](RenderConfig& c) { c.contours = "0.4"; }},
        {"same_scale", [&](RenderConfig& c) { c.ortho = true, c.camera = "front", write_flat(); },
         [](RenderConfig& c) { c.same_scale = true; }},
        {"scale_bar", [](RenderConfig& c) { c.ortho = true, c.size = "400x300"; },
         [](RenderConfig& c) { c.scale_bar = true; }},
    };
    for (const Case& each : cases) {
        RenderConfig c = config("before.png");
        each.before(c);
        const auto before = draw(c).rgba;
        c.output = file("after.png");
        each.change(c);
        EXPECT_NE(before, draw(c).rgba) << each.what;
    }
}

}  // namespace
}  // namespace slim
