#include "pipeline/render/join_shares.h"

#include "tests/pipeline/render/render_outputs_support.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>

// Tasks that share a film or a picture, joined: the bytes that one run makes.

namespace slim {
namespace {

namespace fs = std::filesystem;

class RenderShares : public test::RenderOutputs {
protected:
    void draw_share(RenderConfig c, int i, int n) {
        c.share = std::to_string(i) + "/" + std::to_string(n);
        run(c);
    }
    nlohmann::json join(RenderConfig c, int n) {
        c.join = n;
        return run(c);
    }
    /// Draws in n tasks, the last one first, and joins.
    nlohmann::json drawn_by(const RenderConfig& c, int n) {
        for (int i = n; i >= 1; --i) draw_share(c, i, n);
        return join(c, n);
    }
    /// Names and bytes of the files in a folder, but manifests and what the shares keep.
    std::map<std::string, std::string> contents(const std::string& folder) const {
        std::map<std::string, std::string> out;
        for (const auto& entry : fs::directory_iterator(folder_ / folder)) {
            const std::string name = entry.path().filename().string();
            if (entry.is_regular_file() && !name.ends_with(".done.json"))
                out[name] = bytes(folder + "/" + name);
        }
        return out;
    }
    /// One run and tasks, each into a folder of its own: the same files.
    void expect_same(RenderConfig c, const std::string& name, int n) {
        fs::remove_all(folder_ / "one");
        fs::remove_all(folder_ / "many");
        c.output = file("one/" + name);
        const auto one = run(c);
        c.output = file("many/" + name);
        const auto many = drawn_by(c, n);
        const auto expected = contents("one"), found = contents("many");
        EXPECT_GE(expected.size(), 2u);
        ASSERT_EQ(found.size(), expected.size());
        for (const auto& [file, text] : expected)
            EXPECT_TRUE(found.contains(file) && found.at(file) == text) << file << " of " << n;
        EXPECT_EQ(many["files"].size(), one["files"].size());
        for (const char* key : {"width", "height", "covered_pixels", "rendered_pixels", "ranges"})
            EXPECT_EQ(many[key], one[key]) << key;
        EXPECT_EQ(many["shares"], n);
    }
};

TEST_F(RenderShares, OfAFilmMakeItsPicturesAndLegends) {
    write_torus(3);
    RenderConfig c = config("");
    c.aov = {"shaded", "mean"}, c.lines = {"contour", "suggestive"}, c.up = "z", c.size = "120x90";
    c.turntable = 7, c.camera = "iso";
    // 7 pictures of 3 files each, the legend.
    for (const int n : {1, 2, 3, 7}) expect_same(c, "film.png", n);
    c.same_range = {"front", "top"};
    expect_same(c, "film.png", 3);
    c.lines = {}, c.turntable = 0, c.camera = "front", c.path = "front; iso zoom 2", c.frames = 5;
    expect_same(c, "film.exr", 2);
}

TEST_F(RenderShares, OfAPictureMakeItsBytes) {
    write_torus(3);
    RenderConfig c = config("");
    c.aov = {"all"}, c.size = "300x271", c.camera = "iso", c.up = "z";
    for (const char* name : {"x.png", "x.exr"}) expect_same(c, name, 3);
    // Rows that no band or block of an EXR begins with.
    c.aov = {"shaded", "normal", "id"}, c.size = "90x71";
    expect_same(c, "x.exr", 71);
    c.supersample = 2;
    expect_same(c, "x.png", 4);
    c.supersample = 1, c.antialias = true;
    expect_same(c, "x.png", 4);
    c.mode = "raytrace", c.ao = true, c.ground = true, c.aov = {"shaded", "ao"};
    expect_same(c, "x.exr", 3);
}

TEST_F(RenderShares, OfAPictureWithLinesWriteThemOnce) {
    write_torus(3);
    RenderConfig c = config("");
    c.lines = {"contour", "suggestive", "crest"}, c.size = "300x271", c.camera = "iso", c.up = "z";
    c.lines_ply = file("x.ply"), c.lines_obj = file("x.obj");
    c.output = file("whole.png");
    const auto whole = run(c);
    const std::string ply = bytes("x.ply"), obj = bytes("x.obj");
    fs::remove(file("x.ply")), fs::remove(file("x.obj"));
    c.output = file("joined.png");
    const auto joined = drawn_by(c, 4);
    EXPECT_EQ(bytes("x.ply"), ply);
    EXPECT_EQ(bytes("x.obj"), obj);
    EXPECT_EQ(bytes("joined.lines.svg"), bytes("whole.lines.svg"));
    EXPECT_EQ(bytes("joined.png"), bytes("whole.png"));
    EXPECT_EQ(joined["lines"], whole["lines"]);
    c.lines_ply = c.lines_obj = "";
    expect_same(c, "x.exr", 3);
}

TEST_F(RenderShares, KeepAlphaAsOneRunWould) {
    RenderConfig c = config("");
    c.legend = false, c.zoom = 3, c.aov = {"shaded", "depth"};
    for (const char* background : {"transparent", "white", "#102030,#405060", "auto"}) {
        c.background = background;
        expect_same(c, "x.png", 3);  // zoomed: no pixel without a hit
        c.zoom = 0.7;
        expect_same(c, "x.png", 5);  // rows of nothing but background
        c.zoom = 3;
    }
}

TEST_F(RenderShares, JoinedAreUpToDateAndOneRunIsToo) {
    RenderConfig c = config("x.png");
    drawn_by(c, 3);
    EXPECT_TRUE(run(c).contains("up_to_date"));
    EXPECT_TRUE(join(c, 3).contains("up_to_date"));
    fs::remove(file("x.png"));
    EXPECT_FALSE(join(c, 3).contains("up_to_date"));  // made of the tiles again
    EXPECT_TRUE(exists("x.png"));
    c.turntable = 4, c.output = file("film.png");
    drawn_by(c, 2);
    EXPECT_TRUE(run(c).contains("up_to_date"));
}

TEST_F(RenderShares, ThatAreMissingOrOfOtherOptionsAreNamed) {
    RenderConfig c = config("x.png");
    draw_share(c, 1, 3), draw_share(c, 3, 3);
    const auto refusal = [&] {
        try {
            join(c, 3);
        } catch (const IncompleteError& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_NE(refusal().find(": 2/3: draw"), std::string::npos) << refusal();
    draw_share(c, 2, 3);
    c.zoom = 2;
    EXPECT_NE(refusal().find(": 1/3, 2/3, 3/3: draw"), std::string::npos) << refusal();
    c.zoom = 1;
    write_model(file("m.slim"), test::sphere_model(1, 500), "{}");
    EXPECT_NE(refusal().find("1/3, 2/3, 3/3"), std::string::npos) << refusal();
    EXPECT_FALSE(exists("x.png"));
    for (int i = 1; i <= 3; ++i) draw_share(c, i, 3);
    fs::remove(file("x.png.shares/0003_of_0003/x.png"));
    EXPECT_NE(refusal().find(": 3/3: draw"), std::string::npos) << refusal();
    // A picture of a film is that of its share.
    c.turntable = 5, c.output = file("film.png");
    drawn_by(c, 2);
    fs::remove(file("film_0004.png"));
    c.join = 2;
    EXPECT_NE(error_of(c).find(": 2/2: draw"), std::string::npos) << error_of(c);
}

TEST_F(RenderShares, OfNothingAtAllAreRefusedAsAWhole) {
    RenderConfig c = config("x.png");
    c.camera = "0,0,5,0,0,9,0,1,0";
    draw_share(c, 1, 2), draw_share(c, 2, 2);
    c.join = 2;
    EXPECT_NE(error_of(c).find("not one pixel"), std::string::npos) << error_of(c);
    EXPECT_FALSE(exists("x.png.done.json"));
}

TEST_F(RenderShares, BadOnesAreRefused) {
    const std::pair<const char*, std::function<void(RenderConfig&)>> cases[] = {
        {"expected i/n", [](RenderConfig& c) { c.share = "3/2"; }},
        {"expected i/n", [](RenderConfig& c) { c.share = "0/2"; }},
        {"expected i/n", [](RenderConfig& c) { c.share = "1"; }},
        {"expected i/n", [](RenderConfig& c) { c.share = "1/2x"; }},
        {"at most 60 shares, one for each row", [](RenderConfig& c) { c.share = "1/61"; }},
        {"at most 3 shares, one for each picture",
         [](RenderConfig& c) { c.share = "1/4", c.turntable = 3; }},
        {"at most 60 shares", [](RenderConfig& c) { c.join = 61; }},
        {"leave out crop", [](RenderConfig& c) { c.share = "1/2", c.crop = "0,0,9,9"; }},
        {"leave out tile", [](RenderConfig& c) { c.join = 2, c.tile = "1/2"; }},
        {"leave out repeat", [](RenderConfig& c) { c.share = "1/2", c.repeat = 3; }},
        {"leave out frame", [](RenderConfig& c) { c.share = "1/2", c.turntable = 3, c.frame = 1; }},
        {"not both", [](RenderConfig& c) { c.share = "1/2", c.join = 2; }},
    };
    for (const auto& [message, change] : cases) {
        RenderConfig c = config("x.png");
        change(c);
        EXPECT_NE(error_of(c).find(message), std::string::npos) << message << ": " << error_of(c);
    }
}

}  // namespace
}  // namespace slim
