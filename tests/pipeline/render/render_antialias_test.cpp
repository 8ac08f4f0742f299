#include "slim/base/parallel.h"
#include "tests/pipeline/render/render_outputs_support.h"
#include "tests/pipeline/render/render_trace_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

// Pictures whose pixels at edges have more samples than the others.

namespace slim {
namespace {

class RenderAntialias : public test::RenderOutputs {
protected:
    RenderAntialias() { write_torus(3); }

    RenderConfig small(const std::string& output) const {
        RenderConfig c = config(output);
        c.size = "300x230", c.camera = "iso", c.up = "z", c.legend = false,
        c.background = "transparent";
        return c;
    }

    /// One picture three times: a sample a pixel, four at edges, four everywhere.
    struct Three {
        PngImage plain, smooth, all;
    };
    Three draw_three(RenderConfig c) {
        Three out;
        out.plain = draw(c);
        c.antialias = true;
        out.smooth = draw(c);
        c.antialias = false, c.supersample = 2;
        out.all = draw(c);
        return out;
    }
};

/// Whether no byte differs by more than `most`.
bool same(const PngImage& a, const PngImage& b, int x, int y, int most = 0) {
    return std::equal(test::pixel(a, x, y), test::pixel(a, x, y) + 4, test::pixel(b, x, y),
                      [&](int p, int q) { return std::abs(p - q) <= most; });
}

/// The most that a pixel differs from the eight about it, in bytes of the picture.
int contrast(const PngImage& a, int x, int y) {
    int most = 0;
    for (int v = std::max(0, y - 1); v <= std::min(a.height - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(a.width - 1, x + 1); ++u)
            for (int c = 0; c < 4; ++c)
                most = std::max(most,
                                std::abs(test::pixel(a, x, y)[c] - test::pixel(a, u, v)[c]));
    return most;
}

struct Kinds {
    int sharp = 0;      ///< pixels with the four samples where one would be another colour
    int neither = 0;    ///< that are neither's
    int left = 0;       ///< with much contrast and without the samples
    int needless = 0;   ///< without contrast and with the samples
};

/// most: bytes by which pixels of one kind may differ
Kinds kinds_of(const PngImage& plain, const PngImage& smooth, const PngImage& all, int most = 0) {
    Kinds n;
    for (int y = 0; y < plain.height; ++y)
        for (int x = 0; x < plain.width; ++x) {
            const bool is_plain = same(smooth, plain, x, y, most),
                       is_all = same(smooth, all, x, y, most);
            n.neither += !is_plain && !is_all;
            n.sharp += !is_plain && is_all;
            // The limit is 16 bytes as the square root counts, about that of the curve of sRGB.
            n.left += !is_all && contrast(plain, x, y) > 24;
            n.needless += !is_plain && contrast(plain, x, y) < 8;
        }
    return n;
}

/// Normals at silhouettes are turned to the eye by what lies about them, which is the plain frame:
/// a few pixels are of a shade between.
constexpr int kTurned = 12, kOfHeights = 60;

bool sees_the_eye(const std::string& aov) {
    return aov == "shaded" || aov == "reflection" || aov == "hillshade" || aov == "matcap";
}

TEST_F(RenderAntialias, EdgesAreThoseOfSupersamplingAndTheRestIsPlain) {
    RenderConfig c = small("x.png");
    for (const char* mode : {"forward", "raytrace"})
        for (const char* aov : {"shaded", "normal", "depth", "mean", "dir1", "e1", "position",
                                "reflection", "hillshade", "matcap", "coverage"}) {
            c.mode = mode, c.aov = {aov};
            const auto [plain, smooth, all] = draw_three(c);
            // Contour lines are as wide as the heights beside them say, and only samples about
            // edges have the same ones beside them as all have.
            const Kinds n = kinds_of(plain, smooth, all, aov == std::string("hillshade") ? 20 : 0);
            EXPECT_GT(n.sharp, 300) << mode << aov;
            EXPECT_LE(n.neither, sees_the_eye(aov) ? kTurned : 0) << mode << aov;
            // Heights of contours are drawn at their own size, not averaged.
            EXPECT_LE(n.left, aov == std::string("hillshade") ? kOfHeights : 0) << mode << aov;
            EXPECT_EQ(n.needless, 0) << mode << aov;
        }
}

TEST_F(RenderAntialias, EdgesAreThoseOfSupersamplingInTracedLight) {
    RenderConfig c = small("x.png");
    c.mode = "raytrace", c.ground = c.ao = true;
    c.light = "key angle=5; fill; rect at=2,3,4", c.material = "mirror=0.3";
    for (const char* aov : {"shaded", "ao"}) {
        c.aov = {aov};
        if (c.aov[0] == "ao") c.ao = false, c.light = RenderConfig{}.light, c.material = "";
        const auto [plain, smooth, all] = draw_three(c);
        const Kinds n = kinds_of(plain, smooth, all);
        EXPECT_GT(n.sharp, 300) << aov;
        // What is left is not counted: a shadow's edges are found by its alpha, not on a
        // background.
        EXPECT_LE(n.neither, kTurned) << aov;
    }
}

TEST_F(RenderAntialias, LightsOfForwardProjectionTakeIt) {
    RenderConfig c = small("x.png");
    c.light = "sun azimuth=100 elevation=30";
    const auto [plain, smooth, all] = draw_three(c);
    const Kinds n = kinds_of(plain, smooth, all);
    EXPECT_GT(n.sharp, 300);
    EXPECT_LE(n.neither, kTurned);
    EXPECT_EQ(n.left, 0);
}

TEST_F(RenderAntialias, APictureIsTheSameWhateverElseIsAskedFor) {
    RenderConfig c = small("many.png");
    c.antialias = true, c.aov = {"id", "shaded", "mean", "normal", "lines"},
    c.lines = {"contour", "crest"};
    run(c);
    for (const char* aov : {"shaded", "mean", "normal", "lines"}) {
        RenderConfig one = c;
        one.output = file("one.png"), one.aov = {aov};
        if (one.aov[0] == "lines") one.antialias = false;
        EXPECT_EQ(draw(one).rgba, read_png(file(std::string("many.") + aov + ".png")).rgba) << aov;
    }
}

TEST_F(RenderAntialias, DataKeepTheirMeaningAndColoursAreSmooth) {
    RenderConfig c = small("x.exr");
    c.aov = {"shaded", "id", "depth", "normal", "mean"};
    const ExrImage plain = data_of(c);
    const auto preview = read_png(file("data.png")).rgba;
    c.antialias = true;
    const ExrImage smooth = data_of(c);
    ASSERT_EQ(plain.channels.size(), smooth.channels.size());
    int n_data = 0;
    for (const auto& [name, channel] : plain.channels) {
        const bool is_color = name == "R" || name == "G" || name == "B" || name == "A";
        const auto& other = smooth.channels.at(name);
        EXPECT_EQ(channel.floats == other.floats && channel.integers == other.integers, !is_color)
            << name;
        n_data += !is_color;
    }
    EXPECT_GE(n_data, 6);
    EXPECT_NE(preview, read_png(file("data.png")).rgba);
}

TEST_F(RenderAntialias, ThreadsDoNotMatter) {
    RenderConfig c = small("x.png");
    c.antialias = true, c.aov = {"shaded", "mean"}, c.size = "700x500";
    const auto with = [&](int n) {
        const ThreadLimit limit(n);
        run(c, true);
        return bytes("x.shaded.png") + bytes("x.mean.png");
    };
    const std::string one = with(1);
    EXPECT_EQ(one, with(2));
    EXPECT_EQ(one, with(7));
}

TEST_F(RenderAntialias, CountsItsPixelsAndKeepsThoseOfTheFrame) {
    RenderConfig c = small("x.png");
    const auto plain = run(c);
    c.antialias = true;
    const auto smooth = run(c);
    EXPECT_FALSE(plain.contains("antialiased_pixels"));
    EXPECT_GT(smooth["antialiased_pixels"], 300);
    EXPECT_LT(smooth["antialiased_pixels"], 300 * 230 / 4);
    for (const char* key : {"covered_pixels", "rendered_pixels", "surfels_drawn"})
        EXPECT_EQ(plain[key], smooth[key]) << key;
    c.tile = "2/2";
    const auto lower = run(c);
    c.tile = "1/2";
    const auto upper = run(c);
    EXPECT_EQ(lower["antialiased_pixels"].get<int>() + upper["antialiased_pixels"].get<int>(),
              smooth["antialiased_pixels"].get<int>());
}

TEST_F(RenderAntialias, RepeatedFramesAreTheFirst) {
    RenderConfig c = small("x.png");
    c.antialias = true, c.aov = {"shaded", "mean"};
    const auto pixels = [&] {
        run(c);
        auto both = read_png(file("x.shaded.png")).rgba;
        const auto mean = read_png(file("x.mean.png")).rgba;
        both.insert(both.end(), mean.begin(), mean.end());
        return both;
    };
    const auto once = pixels();
    c.repeat = 3;
    EXPECT_EQ(once, pixels());
}

TEST_F(RenderAntialias, IsRefusedWhereItDoesNothing) {
    const auto on = [](auto change) {
        return [change](RenderConfig& c) { c.antialias = true, change(c); };
    };
    const RefusedCase cases[] = {
        {"antialias", on([](RenderConfig& c) { c.aov = {"id"}; })},
        {"antialias", on([](RenderConfig& c) { c.aov = {"lines"}, c.lines = {"contour"}; })},
        {"--supersample takes", on([](RenderConfig& c) { c.supersample = 2; })},
        {"brute", on([](RenderConfig& c) { c.mode = "brute", c.lod = 0; })},
    };
    expect_each_is_refused(config("x.png"), cases);
}

}  // namespace
}  // namespace slim
