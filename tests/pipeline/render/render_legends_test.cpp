#include "pipeline/render/render_stage.h"

#include "pipeline/render/render_look.h"
#include "pipeline/render/render_maps.h"
#include "pipeline/render/render_uses.h"
#include "raytrace/scale_bar.h"
#include "slim/base/error.h"
#include "slim/tree/curvature_noise.h"
#include "tests/pipeline/render/render_test_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace slim {
namespace {

using RenderLegends = test::RenderTest;
using test::pixel;

/// Pixels that a white-backed map and the same map without its legend do not share, where the
/// latter shows the object.
int n_hidden(const PngImage& with, const PngImage& without) {
    int n = 0;
    for (std::size_t i = 0; i < with.rgba.size(); i += 4) {
        const bool object = without.rgba[i] + without.rgba[i + 1] + without.rgba[i + 2] < 765;
        n += object && !std::equal(&with.rgba[i], &with.rgba[i] + 4, &without.rgba[i]);
    }
    return n;
}

/// A frame of 400 x 400 with a surface where covers(x, y) says so, orthographic.
template <class Covers>
RenderedFrame frame_where(const Covers& covers) {
    RenderedFrame frame;
    frame.size = {400, 400}, frame.pixels.px_per_unit = 20;
    frame.buffer.reset(400, 400, 0);
    for (int y = 0; y < 400; ++y)
        for (int x = 0; x < 400; ++x)
            frame.buffer.hit[static_cast<std::size_t>(400 * y + x)] = covers(x, y);
    return frame;
}

/// "eye 1,2,3 target 4,5,6 up 7,8,9 (...)" as --camera takes it.
std::string camera_numbers(const std::string& described) {
    std::istringstream words(described);
    std::string word, numbers;
    for (int i = 0; i < 6 && words >> word; ++i)
        if (i % 2) numbers += (numbers.empty() ? "" : ",") + word;
    return numbers;
}

TEST_F(RenderLegends, AScaleBarGoesWhereItCoversLeastOfAZoomedView) {
    RenderConfig c = config("x.png");
    c.ortho = true, c.scale_bar = true, c.zoom = 2;
    const auto place = [](const RenderConfig& of, const RenderedFrame& frame) {
        return look_of(of, "shaded", frame, {}, {}).bar_place;
    };
    const RenderedFrame low = frame_where([](int x, int y) { return x < 300 && y > 200; }),
                        all = frame_where([](int, int) { return true; }),
                        left = frame_where([](int x, int) { return x < 120; });
    EXPECT_TRUE(needs_reference(c, "shaded"));
    EXPECT_EQ(place(c, low), LegendPlace::left_top);
    EXPECT_EQ(place(c, all), LegendPlace::left_bottom);  // nowhere better
    EXPECT_EQ(place(c, left), LegendPlace::right_bottom);
    RenderConfig film = c, framed = c;
    film.turntable = 12, framed.zoom = 1;
    for (const RenderConfig& of : {film, framed}) {
        EXPECT_FALSE(needs_reference(of, "shaded"));
        EXPECT_EQ(place(of, low), LegendPlace::left_bottom);
    }
}

TEST_F(RenderLegends, ALegendHidesNothingOfANamedView) {
    RenderConfig c = config("x.png");
    c.aov = {"shaded", "mean"}, c.size = "500x500";
    const auto beside = run(c);
    const PngImage with = read_png(file("x.mean.png"));
    const std::string numbers = camera_numbers(with.metadata.at("slim:camera"));
    EXPECT_EQ(camera_numbers(read_png(file("x.shaded.png")).metadata.at("slim:camera")), numbers);
    // The same view without the legend.
    c.aov = {"mean"}, c.legend = false, c.output = file("bare.png"), c.camera = numbers;
    EXPECT_EQ(n_hidden(with, draw(c)), 0);
    // Without any legend the model is centred, and larger.
    c.aov = {"shaded"}, c.output = file("alone.png"), c.camera = "front";
    EXPECT_GT(run(c)["covered_pixels"].get<int>(), beside["covered_pixels"].get<int>());
}

TEST_F(RenderLegends, PicturesOfOneCameraOverlayWhateverIsAskedForBesideLegends) {
    RenderConfig c = config("x.png");
    c.legend_room = true;
    const auto camera_of = [&](std::vector<std::string> aovs, const char* name) {
        c.aov = std::move(aovs), c.output = file("x.png");
        run(c);
        return read_png(file(name)).metadata.at("slim:camera");
    };
    for (const char* size : {"500x500", "800x300", "64x48"}) {
        c.size = size;
        const std::string shaded = camera_of({"shaded"}, "x.png");
        EXPECT_EQ(camera_of({"mean"}, "x.png"), shaded);
        EXPECT_EQ(camera_of({"level"}, "x.png"), shaded);
        EXPECT_EQ(camera_of({"error", "dir1", "shaded"}, "x.shaded.png"), shaded);
        EXPECT_EQ(camera_of({"error", "dir1", "shaded"}, "x.error.png"), shaded);
    }
}

/// The columns in which something is not white, the first and the last.
std::pair<int, int> drawn_columns(const PngImage& image) {
    int first = image.width, last = -1;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const std::uint8_t* p = pixel(image, x, y);
            if (p[0] + p[1] + p[2] < 765) first = std::min(first, x), last = std::max(last, x);
        }
    return {first, last};
}

TEST_F(RenderLegends, ALegendThatDoesNotFitTakesNoRoom) {
    RenderConfig c = config("x.png");
    c.size = "300x240";  // a key of words would fit
    const auto covered = [&](const char* aov) {
        c.aov = {aov};
        return run(c)["covered_pixels"].get<int>();
    };
    EXPECT_EQ(covered("mean"), covered("shaded"));
    EXPECT_LT(covered("dir1"), covered("shaded"));
}

TEST_F(RenderLegends, WithoutALegendTheModelFillsThePictureFromTheMiddle) {
    RenderConfig c = config("x.png");
    c.size = "500x500", c.background = "white";
    const auto [first, last] = drawn_columns(draw(c));
    EXPECT_NEAR(first, 499 - last, 1);
    EXPECT_LT(first, 70);
    c.zoom = 1.5;  // as much is cut off on either side
    const auto [cut_first, cut_last] = drawn_columns(draw(c));
    EXPECT_EQ(cut_first, 0);
    EXPECT_EQ(cut_last, 499);
}

TEST_F(RenderLegends, ZoomLeavesTheMiddleBesideALegendInItsPlace) {
    for (const bool ortho : {false, true}) {
        RenderConfig c = config("x.png");
        c.size = "640x500", c.background = "white", c.legend_room = true, c.ortho = ortho;
        const auto [first, last] = drawn_columns(draw(c));
        EXPECT_LT(first + last, 620);  // left of the middle
        c.zoom = 0.5;
        const auto [far_first, far_last] = drawn_columns(draw(c));
        EXPECT_NEAR(far_first + far_last, first + last, 3);
        EXPECT_NEAR(far_last - far_first, (last - first) / 2, 0.06 * (last - first));
    }
}

TEST_F(RenderLegends, AZoomThatFillsALegendsRoomKeepsNone) {
    RenderConfig c = config("x.png");
    c.size = "300x400";
    const auto camera_of = [&](bool legend, double zoom) {
        RenderConfig of = c;
        of.aov = {"mean"}, of.legend = legend, of.zoom = zoom;
        run(of);
        return read_png(file("x.png")).metadata.at("slim:camera");
    };
    EXPECT_NE(camera_of(true, 1), camera_of(false, 1));  // the legend is below
    EXPECT_EQ(camera_of(true, 1.5), camera_of(false, 1.5));
    // What is to be of one scale, and films, are framed as before.
    c.ortho = c.same_scale = true;
    EXPECT_NE(camera_of(true, 1.5), camera_of(false, 1.5));
    // At the right it keeps its room until that is filled.
    c.ortho = c.same_scale = false, c.size = "400x200";
    EXPECT_NE(camera_of(true, 1.2), camera_of(false, 1.2));
    EXPECT_EQ(camera_of(true, 2), camera_of(false, 2));
}

TEST_F(RenderLegends, AZoomThatFillsAScaleBarsStripKeepsNone) {
    RenderConfig c = config("x.png");
    c.size = "300x300", c.ortho = true;
    const auto camera_of = [&](bool scale_bar, double zoom) {
        RenderConfig of = c;
        of.scale_bar = scale_bar, of.zoom = zoom;
        run(of);
        return read_png(file("x.png")).metadata.at("slim:camera");
    };
    EXPECT_NE(camera_of(true, 1), camera_of(false, 1));
    EXPECT_NE(camera_of(true, 1.02), camera_of(false, 1.02));  // still free
    EXPECT_EQ(camera_of(true, 3), camera_of(false, 3));
    c.same_scale = true;  // one room for all sides
    EXPECT_NE(camera_of(true, 3), camera_of(false, 3));
}

TEST_F(RenderLegends, WordsNeverStandOverAScaleBar) {
    RenderConfig c = config("x.png");
    c.aov = {"hillshade"}, c.ortho = c.scale_bar = true, c.up = "z", c.camera = "top";
    const auto looks = [&](int width, int height, int covered) {
        RenderedFrame frame;
        frame.size = {width, height}, frame.pixels.px_per_unit = 0.25 * width;
        frame.buffer.reset(width, height, 0);
        for (int y = 0; y < covered; ++y)
            for (int x = 0; x < width; ++x)
                frame.buffer.hit[static_cast<std::size_t>(width * y + x)] = 1;
        ContourLevels lines;
        lines.spacing = 0.1, lines.heavy_spacing = 0.5, lines.lines = 9, lines.heavy = 2;
        return look_of(c, "hillshade", frame, {}, lines);
    };
    int n_fit = 0, n_left_out = 0;
    for (int height = 90; height <= 200; height += 3) {
        SCOPED_TRACE(height);
        const int width = 4 * height / 3;
        const AovLook look = looks(width, height, height / 2);  // what is seen is above
        ASSERT_TRUE(look.key.has_value());
        const double shared =
            shared_area(key_box(*look.key, look.place, width, height),
                        scale_bar_box({0.25 * width, ""}, width, height, look.bar_place));
        EXPECT_TRUE(shared == 0 || !look.words_fit) << shared;
        (look.words_fit ? n_fit : n_left_out) += 1;
    }
    EXPECT_GT(n_fit, 5);
    EXPECT_GT(n_left_out, 0);
    // The view of a named camera has room for both, small as it is.
    c.size = "200x150", c.background = "white";
    RenderConfig bare = c;
    bare.legend = false, bare.legend_room = true, bare.output = file("bare.png");
    EXPECT_EQ(n_hidden(draw(c), draw(bare)), 0);
}

TEST_F(RenderLegends, TheOrderOfAovsOfAnExrFramesNothing) {
    RenderConfig c = config("x.exr");
    c.size = "500x500";
    const auto covered = [&](std::vector<std::string> aovs) {
        c.aov = std::move(aovs);
        return run(c)["covered_pixels"].get<int>();
    };
    EXPECT_EQ(covered({"shaded", "mean"}), covered({"mean", "shaded"}));
}

TEST_F(RenderLegends, AnExrIsFramedAsIfThereWereNoLegendsThatNoPictureHas) {
    RenderConfig c = config("x.exr");
    c.size = "500x500";
    const auto camera = [&](std::vector<std::string> aovs) {
        c.aov = std::move(aovs);
        run(c);
        return read_exr(c.output).metadata.at("slim:camera");
    };
    const std::string plain = camera({"shaded"});
    for (const char* aov : {"dir1", "hillshade", "mean", "all"}) {
        EXPECT_EQ(camera({"shaded", aov}), plain) << aov;
        EXPECT_EQ(camera({aov, "shaded"}), plain) << aov;  // whose preview has a legend
    }
    c.legend_room = true;
    EXPECT_NE(camera({"shaded"}), plain);
}

TEST_F(RenderLegends, RoomForALegendIsForCamerasThatFrame) {
    RenderConfig c = config("x.png");
    c.legend_room = true, c.camera = "0,0,5,0,0,0,0,1,0";
    EXPECT_THROW(run(c), ConfigError);
    c.camera = "front", c.ortho_width = 8;
    EXPECT_THROW(run(c), ConfigError);
}

TEST_F(RenderLegends, ALegendsRoomIsThatOfAovsThatHaveOne) {
    RenderConfig any;
    const FieldList fields = fields_of(any);
    for (const std::string& aov : fields.find("aov")->choices) {
        if (aov == "all") continue;
        EXPECT_EQ(has_legend(any, {aov}), needs_reference(any, aov)) << aov;
    }
    EXPECT_TRUE(has_legend(any, {"all"}));
    any.contours = "none";
    EXPECT_FALSE(has_legend(any, {"hillshade", "shaded"}));
    any.legend = false;
    EXPECT_FALSE(has_legend(any, {"mean"}));
}

TEST_F(RenderLegends, AnExplicitCameraStaysAndTheLegendGoesWhereItHidesLeast) {
    RenderConfig c = config("x.png");
    c.aov = {"mean"}, c.size = "500x500", c.background = "white";
    c.camera = "-1,0,7,-1,0,0,0,1,0";  // the sphere right of the middle
    const PngImage with = draw(c);
    c.legend = false, c.output = file("y.png");
    EXPECT_EQ(n_hidden(with, draw(c)), 0);
}

/// Pixels of a map whose curvatures are k1 and k2, with noise of `noise` in both.
GBuffer bent(double k1, double k2, double noise) {
    GBuffer b;
    b.reset(40, 25, kCurvatureChannel);
    for (std::size_t i = 0; i < b.n_pixels(); ++i) {
        b.hit[i] = 1;
        const double off = noise * std::sin(static_cast<double>(i));
        b.k1[i] = static_cast<float>(k1 + off), b.k2[i] = static_cast<float>(k2 - 0.7 * off);
        b.mean[i] = (b.k1[i] + b.k2[i]) / 2, b.gauss[i] = b.k1[i] * b.k2[i];
    }
    return b;
}

TEST(MapRange, OfFlatFacesAndCylindersIsNotThatOfTheFitsNoise) {
    const RenderConfig config;
    constexpr double kDiagonal = 50;
    const auto range = [&](const std::string& aov, const GBuffer& b) {
        return map_range(config, aov, aov == "mean" ? b.mean : b.gauss, b, {kDiagonal, 0.012}).hi;
    };
    // Planes: radii of 5 diagonals where the fit is worst, as it says of itself.
    EXPECT_GE(range("mean", bent(0, 0, 0.004)), 0.01);
    // Cylinders of radius 5: the Gauss curvature is 0, the noise of k2 a tenth of k1.
    const GBuffer cylinder = bent(0.2, 0, 0.02);
    EXPECT_GE(range("gauss", cylinder), 0.0099);
    EXPECT_NEAR(range("mean", cylinder), 0.1, 0.021);
    // Also where most of the picture is faces with what the fit makes of them.
    GBuffer part = cylinder;
    for (std::size_t i = 0; i < part.n_pixels(); ++i)
        if (i % 5 < 3)
            part.k1[i] = part.k2[i] = part.mean[i] = 0.005f, part.gauss[i] = 2.5e-5f;
    EXPECT_GE(range("gauss", part), 0.0075);
    // Balls, and what is more bent than in the middle: as before.
    EXPECT_NEAR(range("gauss", bent(0.2, 0.2, 0)), 0.04, 1e-6);
    GBuffer scan = bent(0.3, -0.2, 0.01);
    EXPECT_NEAR(range("gauss", scan), 0.06, 0.021);
}

TEST(MapRange, OfGentleSurfacesIsTheirsUnlessTheFitKnowsLess) {
    const RenderConfig config;
    constexpr double kDiagonal = 50, kDish = 0.05 / kDiagonal;  // of 20 diagonals
    const auto range = [&](const std::string& aov, const GBuffer& b, double noise) {
        return map_range(config, aov, aov == "mean" ? b.mean : b.gauss, b, {kDiagonal, noise}).hi *
               kDiagonal * (aov == "mean" ? 1 : kDiagonal);
    };
    const GBuffer dish = bent(-kDish, -kDish, 0.1 * kDish);
    EXPECT_NEAR(range("mean", dish, 0), 0.05, 0.011);
    EXPECT_NEAR(range("mean", dish, 0.5 * kDish), 0.05, 0.011);
    EXPECT_NEAR(range("gauss", dish, 0.5 * kDish), 0.0025, 0.0006);
    EXPECT_NEAR(range("mean", bent(kDish, 0, 0), 0), 0.025, 1e-6);  // a bent plate
    // Pixels of small leaves at its rim do not make it a flat face.
    GBuffer rim = dish;
    for (std::size_t i = 0; i < rim.n_pixels(); i += 50)
        rim.mean[i] = 20 * static_cast<float>(kDish);
    EXPECT_NEAR(range("mean", rim, 0.5 * kDish), 0.05, 0.011);
    // What the fit does not know is pale, up to radii of 2 diagonals, as the noise of scans is not
    // to change their ranges; so is what is bent to radii of more than 80.
    EXPECT_NEAR(range("mean", dish, 3 * kDish), 0.15, 0.051);
    EXPECT_NEAR(range("mean", dish, 100 * kDish), 0.5, 1e-6);
    EXPECT_NEAR(range("mean", bent(0.6 * kDish, 0, 0), 0), 0.025, 1e-6);
    EXPECT_NEAR(range("mean", bent(1e-3 * kDish, 0, 0), 0), 0.5, 1e-6);  // flat
}

TEST(MapRange, OfExactFacesIsNotThatOfLeavesAtTheirEdges) {
    const RenderConfig config;
    constexpr double kDiagonal = 5.6;
    const auto range = [&](const std::string& aov, const GBuffer& b) {
        return map_range(config, aov,
                         aov == "mean" ? b.mean : aov == "k1" ? b.k1 : b.gauss, b, {kDiagonal, 0})
            .hi;
    };
    // As twelve_original: one leaf in twenty has taken a point of the next face along.
    GBuffer faces = bent(0, 0, 1e-4 / kDiagonal);
    for (std::size_t i = 0; i < faces.n_pixels(); i += 20) {
        faces.k1[i] = static_cast<float>(0.0213 / kDiagonal), faces.k2[i] = 0;
        faces.mean[i] = faces.k1[i] / 2, faces.gauss[i] = 0;
    }
    EXPECT_GE(range("mean", faces), 0.5 / kDiagonal);
    EXPECT_GE(range("k1", faces), 0.5 / kDiagonal);
    EXPECT_GE(range("gauss", faces), 0.25 / (kDiagonal * kDiagonal));
    // Round parts of 2 in 100 pixels still have their own.
    for (std::size_t i = 0; i < faces.n_pixels(); i += 50)
        faces.mean[i] = static_cast<float>(0.2 / kDiagonal);
    EXPECT_NEAR(range("mean", faces), 0.2 / kDiagonal, 0.05 / kDiagonal);
}

/// As curvature_noise() of all that it is to look at.
double noise_of(const SurfelTreeData& model) {
    return curvature_noise(model.view(), nodes_for_curvature_noise(model.view()));
}

TEST(CurvatureNoise, OfALargeModelIsOfFewRunsOfItsNodes) {
    SurfelTreeData model;
    model.nodes.resize(65537);
    const SampledNodes sample = nodes_for_curvature_noise(model.view());
    const auto& nodes = sample.nodes;
    EXPECT_LE(nodes.size(), 2000u);
    EXPECT_EQ(nodes.front(), 1u);
    std::size_t n_runs = 1;
    for (std::size_t i = 1; i < nodes.size(); ++i) {
        ASSERT_GT(nodes[i], nodes[i - 1]);
        n_runs += nodes[i] != nodes[i - 1] + 1;
    }
    EXPECT_LE(n_runs, 60u);
    EXPECT_LT(nodes.back(), model.nodes.size());
    EXPECT_NEAR(std::accumulate(sample.stand_for.begin(), sample.stand_for.end(), 0.0), 65536,
                1e-6);
    // Large leaves come first; the sample says of them what all do.
    for (std::size_t i = 1; i < model.nodes.size(); ++i) {
        TreeNode& node = model.nodes[i];
        node.flags = kLeaf, node.n_points = 100;
        node.bound_radius = i < 6000 ? 5 : 1;
        node.fit_error = i < 6000 ? 0.25f : 9;
    }
    EXPECT_NEAR(noise_of(model), 140 * 0.25 / (25 * 10), 1e-5);
    model.nodes.pop_back();  // small ones are read whole
    EXPECT_EQ(nodes_for_curvature_noise(model.view()).nodes.size(), 65535u);
}

TEST(CurvatureNoise, IsThatOfTheMiddleLeafByItsResidualRadiusAndPoints) {
    SurfelTreeData model;
    const auto leaf = [](float error, float radius, std::uint32_t n, std::uint8_t flags = kLeaf) {
        TreeNode node;
        node.fit_error = error, node.bound_radius = radius, node.n_points = n, node.flags = flags;
        return node;
    };
    EXPECT_EQ(noise_of(model), 0);
    model.nodes = {leaf(9, 1, 4, 0), leaf(0.01f, 2, 400), leaf(9, 0.1f, 4), leaf(9, 0.1f, 4),
                   leaf(9, 5, 400, 0), leaf(9, 1, 0)};
    EXPECT_NEAR(noise_of(model), 140 * 0.01 / (4 * 20), 1e-6);
    // Of two that share the surface the one that is known better.
    model.nodes = {leaf(9, 1, 4, 0), leaf(0.01f, 2, 400), leaf(0.005f, 2.1f, 100)};
    EXPECT_NEAR(noise_of(model), 140 * 0.005 / (2.1 * 2.1 * 10), 1e-5);
}

}  // namespace
}  // namespace slim
