#include "pipeline/render/render_parts.h"

#include "raytrace/lines/extract.h"
#include "raytrace/lines/lines_geometry.h"
#include "raytrace/project/forward_renderer.h"
#include "slim/tree/curvature_noise.h"
#include "slim/tree/drawn_bounds.h"
#include "tests/pipeline/render/render_outputs_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

// Parts of pictures: crops, tiles, bands, and what of a model is read for them.

namespace slim {
namespace {

using RenderParts = test::RenderOutputs;

PngImage part_of(const PngImage& whole, int x0, int y0, int width, int height) {
    PngImage out{width, height, 4, {}, {}};
    for (int y = y0; y < y0 + height; ++y) {
        const auto* row = &whole.rgba[4 * static_cast<std::size_t>(y * whole.width + x0)];
        out.rgba.insert(out.rgba.end(), row, row + 4 * width);
    }
    return out;
}

/// Beside 1 and 2 along a pixel's side: more than one only where it matters.
constexpr int kAtEdges = 0;

void take_samples(RenderConfig& c, int samples) {
    c.antialias = samples == kAtEdges;
    c.supersample = samples == kAtEdges ? 1 : samples;
}

TEST_F(RenderParts, ACropIsTheWholesBytesInEveryAov) {
    write_torus(3);
    for (const int samples : {1, 2, kAtEdges}) {
        RenderConfig c = config("whole.png");
        c.aov = {"all"}, c.size = "390x310", c.ortho = true, c.scale_bar = true;
        take_samples(c, samples);
        run(c);
        c.output = file("part.png"), c.crop = "61,83,171,202";
        run(c);
        std::size_t n = 0;
        for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
            const std::string name = entry.path().filename().string();
            if (!name.starts_with("whole.") || entry.path().extension() != ".png") continue;
            const PngImage part = read_png(file("part" + name.substr(5)));
            EXPECT_EQ(part.rgba, part_of(read_png(entry.path()), 61, 83, 171, 202).rgba)
                << name << samples;
            ++n;
        }
        EXPECT_EQ(n, 22u);
    }
}

TEST_F(RenderParts, TilesMakeTheWhole) {
    RenderConfig c = config("whole.png");
    c.aov = {"mean"}, c.size = "300x271";
    const PngImage whole = draw(c);
    std::vector<std::uint8_t> rows;
    for (int i = 1; i <= 4; ++i) {
        c.tile = std::to_string(i) + "/4", c.output = file("tile" + std::to_string(i) + ".png");
        const auto tile = draw(c).rgba;
        rows.insert(rows.end(), tile.begin(), tile.end());
    }
    EXPECT_EQ(rows, whole.rgba);
}

const std::vector<std::string> kAllLines{"contour", "suggestive", "crest", "parabolic",
                                         "reflection"};

TEST_F(RenderParts, PartsShowTheLinesOfTheWhole) {
    write_torus(3);
    for (const int samples : {1, 2, kAtEdges}) {
        RenderConfig c = config("whole.png");
        c.aov = {"shaded", "lines", "mean"}, c.lines = kAllLines;
        c.camera = "iso", c.up = "z", c.size = "390x310";
        take_samples(c, samples);
        const auto whole = run(c);
        for (const char* kind : {"contour", "parabolic", "reflection"})
            EXPECT_GT(whole["lines"][kind]["polylines"], 0) << kind;
        c.output = file("part.png"), c.crop = "61,83,171,202";
        run(c);
        for (const std::string aov : {"shaded", "lines", "mean"})
            EXPECT_EQ(read_png(file("part." + aov + ".png")).rgba,
                      part_of(read_png(file("whole." + aov + ".png")), 61, 83, 171, 202).rgba)
                << aov << samples;
        EXPECT_NE(bytes("part.lines.svg").find("viewBox=\"16.140 21.960 45.244 53.446\""),
                  std::string::npos);
    }
}

TEST_F(RenderParts, TilesWithLinesMakeTheWholeAndItsData) {
    write_torus(3);
    RenderConfig c = config("x.exr");
    c.lines = kAllLines, c.camera = "iso", c.up = "z", c.size = "200x171";
    const ExrImage whole = data_of(c);
    for (const char* channel : {"lines.suggestive", "marks.contour", "marks.reflection", "R"}) {
        std::vector<float> rows;
        for (int i = 1; i <= 3; ++i) {
            c.tile = std::to_string(i) + "/3";
            const auto tile = data_of(c).channels.at(channel).floats;
            rows.insert(rows.end(), tile.begin(), tile.end());
        }
        EXPECT_EQ(rows, whole.channels.at(channel).floats) << channel;
    }
}

TEST_F(RenderParts, LinesOfAPartAreThoseThatTouchIt) {
    write_torus(2);
    RenderConfig c = config("x.png");
    c.lines = {"contour"}, c.camera = "top", c.up = "z", c.size = "300x300";
    const auto n = run(c)["lines"]["contour"]["polylines"].get<int>();
    c.lines_ply = file("x.ply");
    const std::string all = (run(c), bytes("x.ply"));
    c.crop = "0,130,60,40";
    const auto within = run(c)["lines"]["contour"]["polylines"].get<int>();
    EXPECT_GT(within, 0);
    EXPECT_LT(within, n);
    EXPECT_LT(bytes("x.ply").size(), all.size());
    c.crop = "0,0,9,9";
    EXPECT_EQ(run(c)["lines"]["contour"]["polylines"], 0);
}

TEST_F(RenderParts, LinesOfAPictureInBandsAreThoseOfTheWhole) {
    const auto model = test::torus_model(1, 0.35, 60, 24, 3);
    write_model(file("m.slim"), model, "{}");
    RenderConfig c = config("x.png");
    c.lines = kAllLines, c.aov = {"lines"}, c.size = "2300x2300", c.lines_ply = file("x.ply");
    c.camera = "4,0,1.2,0,0,0,0,0,1", c.lod = 0;
    run(c);
    RenderRequest request;
    request.camera.eye = {4, 0, 1.2}, request.camera.target = {0, 0, 0},
    request.camera.up = {0, 0, 1};
    request.camera.fov_y_deg = c.fov, request.width = request.height = 2300, request.lod_px = 0;
    request.wanted = line_channels(kAllLineKinds, 3);
    GBuffer frame;
    const SurfelTree tree = model.view();
    render_forward(tree, request, frame);
    const std::vector<LineKind> kinds{LineKind::reflection, LineKind::parabolic,
                                      LineKind::suggestive, LineKind::valley,
                                      LineKind::ridge,      LineKind::contour};
    const LineScene scene{frame, pixel_view(request.camera, 2300, 2300), tree.header().diagonal, 3};
    EXPECT_EQ(bytes("x.ply"), lines_ply(extract_lines(scene, kinds), tree.header().origin));
    // The planes that lines take do not fit a band: position, normal, k1, k2, Gauss, direction,
    // four derivatives.
    EXPECT_GT(
        picture_parts({2300, 2300}, {0, 0, 2300, 2300}, 4 * (3 + 3 + 3 + 3 + 4) + 20, 0).size(),
        1u);
}

TEST_F(RenderParts, ACropsDataLieWhereTheyBelong) {
    RenderConfig c = config("x.exr");
    c.aov = {"depth", "shaded"}, c.crop = "30,20,11,7";
    const ExrImage part = data_of(c);
    c.crop = "";
    const ExrImage whole = data_of(c);
    ASSERT_EQ(part.width, 11);
    for (const char* channel : {"Z", "R", "A"})
        for (int y = 0; y < 7; ++y)
            for (int x = 0; x < 11; ++x)
                ASSERT_EQ(part.channels.at(channel).floats[static_cast<std::size_t>(y * 11 + x)],
                          whole.channels.at(channel)
                              .floats[static_cast<std::size_t>((20 + y) * 80 + 30 + x)]);
}

TEST_F(RenderParts, Row40HugePicturesAreDrawnInBandsOfBoundedMemory) {
    const PictureSize size{16384, 16384};
    const auto parts = picture_parts(size, {0, 0, 16384, 16384}, 50, shading_margin(size));
    int next = 0;
    for (const PicturePart& part : parts) {
        EXPECT_EQ(part.wanted.y, next);
        EXPECT_LE(50ull * static_cast<unsigned>(part.wanted.width * part.wanted.height),
                  384ull << 20);
        EXPECT_EQ(part.drawn.y % 32 + part.drawn.x % 32, 0);
        EXPECT_LE(part.drawn.y, std::max(0, part.wanted.y - 82));
        EXPECT_GE(part.drawn.y + part.drawn.height,
                  std::min(16384, part.wanted.y + part.wanted.height + 82));
        next += part.wanted.height;
    }
    EXPECT_EQ(next, 16384);
    EXPECT_GT(parts.size(), 10u);
}

TEST_F(RenderParts, AViewOfAPartReadsThatPartOfTheModel) {
    write_model(file("m.slim"), test::two_level_sphere(1, 100, 250000), "{}");
    ASSERT_GT(std::filesystem::file_size(file("m.slim")), std::uintmax_t{16} << 20);
    RenderConfig c = config("x.png");
    const auto whole = run(c);
    EXPECT_EQ(whole["model_bytes_read"], whole["model_bytes"]);
    c.zoom = 30, c.lod = 0;
    const auto part = run(c);
    EXPECT_LT(part["nodes_visited"].get<double>(), 0.2 * part["nodes"].get<double>());
    EXPECT_LT(part["model_bytes_read"].get<double>(), 0.4 * part["model_bytes"].get<double>());
    EXPECT_GE(part["model_bytes_read"].get<double>(), 24 * part["nodes_visited"].get<double>());
}

TEST_F(RenderParts, ARangeOfCurvatureIsOfNodesThatWereChecked) {
    SurfelTreeData model = test::two_level_sphere(1, 100, 250000);
    set_drawn_bounds(model);  // cameras are framed without looking at leaves
    const SampledNodes sample = nodes_for_curvature_noise(model.view());
    write_model(file("m.slim"), model, "{}");
    RenderConfig c = config("x.png");
    c.camera = "right", c.zoom = 30, c.lod = 0, c.aov = {"normal"};
    const auto other = run(c);
    c.aov = {"mean"};
    const auto mean = run(c);
    // What they are read for is counted, and is little.
    const double more =
        mean["model_bytes_read"].get<double>() - other["model_bytes_read"].get<double>();
    EXPECT_GT(more, 24 * 0.5 * static_cast<double>(sample.nodes.size()));
    EXPECT_LT(more, 1e6);
    EXPECT_GT(mean["model_nodes_checked"], other["model_nodes_checked"]);
    EXPECT_LT(mean["model_nodes_checked"].get<double>(),
              other["model_nodes_checked"].get<double>() + 2000);
    // Damage to one is seen that the view does not meet, as it lies beside.
    std::size_t far = sample.nodes.back();
    for (const std::uint32_t i : sample.nodes)
        if (model.nodes[i].is_leaf() && model.view().center(i).y > model.view().center(far).y)
            far = i;
    model.nodes[far].fit_error = std::numeric_limits<float>::quiet_NaN();
    write_model(file("m.slim"), model, "{}");
    c.aov = {"normal"};
    EXPECT_NO_THROW(run(c, true));
    c.aov = {"mean"};
    EXPECT_THROW(run(c, true), FormatError);
}

TEST_F(RenderParts, CamerasOfTheSameRangeReadWhatTheySee) {
    write_model(file("m.slim"), test::two_level_sphere(1, 100, 250000), "{}");
    RenderConfig c = config("x.png");
    c.aov = {"depth"};
    c.zoom = 30, c.lod = 0;
    const auto alone = run(c);
    c.same_range = {"back"};  // zoomed as well: the far side
    const auto both = run(c);
    EXPECT_GT(both["model_bytes_read"], alone["model_bytes_read"]);
    c.same_range = {"front", "back", "left", "right", "top", "bottom", "iso"};
    EXPECT_GT(run(c)["model_bytes_read"], both["model_bytes_read"]);
}

TEST_F(RenderParts, AFilmOfAPartReadsThatPartOnce) {
    write_model(file("m.slim"), test::two_level_sphere(1, 100, 250000), "{}");
    RenderConfig c = config("x.png");
    c.lod = 0;
    c.path = "front zoom 30; front zoom 40", c.frames = 2;
    const auto two = run(c);
    c.frames = 12;
    const auto film = run(c);
    EXPECT_EQ(film["frames"], 12);
    // The wider end is the first picture, and what the others see lies in it.
    EXPECT_LT(film["model_bytes_read"].get<double>(), 0.4 * film["model_bytes"].get<double>());
    EXPECT_LE(film["model_bytes_read"].get<double>(), 1.1 * two["model_bytes_read"].get<double>());
    EXPECT_GT(film["model_nodes_checked"], 0);
    EXPECT_LT(film["model_nodes_checked"].get<double>(), 0.3 * film["nodes_visited"].get<double>());
    // A film all around meets everything: then it is checked as a whole.
    c.path = "", c.frames = 0, c.turntable = 4;
    const auto around = run(c);
    EXPECT_EQ(around["model_bytes_read"], around["model_bytes"]);
}

TEST_F(RenderParts, APictureOfAFilmAloneIsTheSame) {
    write_model(file("m.slim"), test::two_level_sphere(1, 100, 250000), "{}");
    RenderConfig c = config("film.png");
    c.path = "front zoom 30; iso zoom 30", c.frames = 3, c.aov = {"depth"};
    run(c);
    c.output = file("second.png"), c.frame = 2;
    run(c);
    EXPECT_EQ(read_png(file("film_0002.png")).rgba, read_png(file("second_0002.png")).rgba);
}

TEST_F(RenderParts, DamageThatAFilmMeetsEndsIt) {
    SurfelTreeData model = test::two_level_sphere(1, 100, 250000);
    const SurfelTree tree = model.view();
    // The leaf nearest the eye of the second picture; the first one looks past it.
    std::size_t farthest = 1;
    for (std::size_t i = 1; i < tree.n_nodes(); ++i)
        if (tree.node(i).is_leaf() && tree.center(i).x > tree.center(farthest).x) farthest = i;
    set_drawn_bounds(model);  // cameras are framed without looking at leaves
    model.records[12 * farthest + 5] = 3;  // no normal
    write_model(file("m.slim"), model, "{}");
    RenderConfig c = config("x.png");
    c.lod = 0, c.path = "front zoom 30; right zoom 30", c.frames = 2;
    try {
        run(c);
        FAIL() << "the damage was not seen";
    } catch (const FormatError& error) {
        EXPECT_NE(std::string(error.what()).find("node " + std::to_string(farthest)),
                  std::string::npos)
            << error.what();
    }
    EXPECT_TRUE(std::filesystem::exists(file("x_0001.png")));
    EXPECT_FALSE(std::filesystem::exists(file("x_0002.png")));
}

TEST_F(RenderParts, AViewOfAPartOfASmallModelSeesDamageElsewhere) {
    write_model(file("m.slim"), test::two_level_sphere(1, 100, 20000), "{}");
    RenderConfig c = config("x.png");
    c.zoom = 30, c.lod = 0;
    const auto sound = run(c);
    EXPECT_EQ(sound["model_bytes_read"], sound["model_bytes"]);
    std::string damaged = bytes("m.slim");
    damaged[damaged.size() * 9 / 10] ^= 1;  // a record of the far side
    std::ofstream(file("m.slim"), std::ios::binary) << damaged;
    EXPECT_THROW(run(c, true), FormatError);  // the manifest knows the table alone
}

}  // namespace
}  // namespace slim
