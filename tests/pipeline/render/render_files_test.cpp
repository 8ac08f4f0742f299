#include "pipeline/render/render_files.h"

#include "pipeline/manifest.h"
#include "slim/base/error.h"
#include "tests/pipeline/render/render_test_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace slim {
namespace {

using test::RenderTest;
using RenderFiles = RenderTest;

TEST_F(RenderFiles, OnePictureTakesTheNameItIsGiven) {
    run(config("x.png"));
    EXPECT_TRUE(exists("x.png"));
    EXPECT_FALSE(exists("x.shaded.png"));
}

TEST_F(RenderFiles, TheCaseOfAnExtensionDoesNotMatterAndIsKept) {
    run(config("x.PNG"));
    EXPECT_TRUE(exists("x.PNG"));
    EXPECT_TRUE(exists("x.PNG.done.json"));
    RenderConfig c = config("y.Png");
    c.aov = {"shaded", "mean"};
    run(c);
    EXPECT_TRUE(exists("y.shaded.Png"));
    EXPECT_TRUE(exists("y.mean.Png"));
    c = config("z.EXR");
    c.format = "exr";
    run(c);
    EXPECT_TRUE(exists("z.EXR"));
    EXPECT_TRUE(exists("z.png"));
    c.format = "png";
    EXPECT_THROW(run(c), ConfigError);
}

TEST_F(RenderFiles, SeveralPicturesAreNamedByAov) {
    RenderConfig c = config("x.png");
    c.aov = {"shaded", "mean", "shaded"};
    const auto result = run(c);
    EXPECT_TRUE(exists("x.shaded.png"));
    EXPECT_TRUE(exists("x.mean.png"));
    EXPECT_TRUE(exists("x.mean.legend.svg"));
    EXPECT_FALSE(exists("x.png"));
    EXPECT_EQ(result["files"].size(), 3u);
}

TEST_F(RenderFiles, ALegendIsNamedAfterItsPictureAndAovOnce) {
    RenderConfig c = config("top.mean.png");
    c.aov = {"mean"};
    run(c);
    EXPECT_TRUE(exists("top.mean.legend.svg"));
    EXPECT_FALSE(exists("top.mean.mean.legend.svg"));
    c.output = file("x.png");
    run(c);
    EXPECT_TRUE(exists("x.mean.legend.svg"));
}

TEST_F(RenderFiles, AFolderTakesViewAndAov) {
    RenderConfig c = config("pictures");
    c.camera = "iso";
    run(c);
    EXPECT_TRUE(exists("pictures/iso.shaded.png"));
    c.name = "hero";
    run(c);
    EXPECT_TRUE(exists("pictures/hero.shaded.png"));
    c.name = "";
    c.camera = "0,0,5,0,0,0,0,1,0";
    c.output = file("more.v2/");
    run(c);
    EXPECT_TRUE(exists("more.v2/view.shaded.png"));
    c.output = file("more.v2");
    c.camera = "top";
    run(c);
    EXPECT_TRUE(exists("more.v2/top.shaded.png"));
}

TEST_F(RenderFiles, AnExrHasAPreviewBesideIt) {
    RenderConfig c = config("x.exr");
    c.aov = {"shaded", "depth"};
    run(c);
    EXPECT_TRUE(exists("x.exr"));
    EXPECT_TRUE(exists("x.png"));
    EXPECT_FALSE(exists("x.depth.png"));
    c.output = file("folder");
    c.format = "exr";
    run(c);
    EXPECT_TRUE(exists("folder/front.exr"));
    EXPECT_TRUE(exists("folder/front.png"));
}

TEST_F(RenderFiles, WrongExtensionsAreRefused) {
    RenderConfig c = config("x.jpg");
    EXPECT_THROW(run(c), ConfigError);
    c = config("x.png");
    c.format = "exr";
    EXPECT_THROW(run(c), ConfigError);
    std::ofstream(file("wall")) << "a file";
    c = config("wall/in/it");
    EXPECT_THROW(run(c), IoError);
}

bool is_light(const std::string& channel) {
    return (channel.size() == 1 && channel != "Z") || channel.ends_with(".R") ||
           channel.ends_with(".G") || channel.ends_with(".B");
}

TEST_F(RenderFiles, ExrHoldsTheConventionsChannels) {
    RenderConfig c = config("x.exr");
    c.aov = {"all"};
    run(c);
    const ExrImage image = read_exr(file("x.exr"));
    std::vector<std::string> names;
    for (const auto& [name, channel] : image.channels) names.push_back(name);
    const std::vector<std::string> conventions{
        "A", "B", "G", "N.X", "N.Y", "N.Z", "P.X", "P.Y", "P.Z", "R", "Z", "curvature.gauss",
        "curvature.k1", "curvature.k2", "curvature.mean", "dir1.X", "dir1.Y", "dir1.Z",
        "dir2.X", "dir2.Y", "dir2.Z", "environment.B", "environment.G", "environment.R",
        "fit.coverage", "fit.error", "fit.level", "hillshade.B", "hillshade.G", "hillshade.R",
        "matcap.B", "matcap.G", "matcap.R", "reflection.B", "reflection.G", "reflection.R",
        "surfel.id"};
    EXPECT_EQ(names, conventions);
    for (const auto& [name, channel] : image.channels)
        EXPECT_EQ(channel.type, is_light(name)        ? ChannelType::half_float
                                : name == "surfel.id" ? ChannelType::uint32
                                                      : ChannelType::float32)
            << name;
    const std::size_t middle = 30 * 80 + 40;
    EXPECT_NEAR(image.channels.at("N.Z").floats[middle], 1, 0.01);
    EXPECT_NEAR(image.channels.at("P.Z").floats[middle], 1, 0.01);
    EXPECT_NEAR(image.channels.at("curvature.mean").floats[middle], 1, 0.05);
    EXPECT_EQ(image.channels.at("fit.level").floats[middle], 3);
    EXPECT_GT(image.channels.at("surfel.id").integers[middle], 0u);
    EXPECT_EQ(image.channels.at("A").floats[middle], 1);
    for (const auto& [name, channel] : image.channels)  // no hit: zero everywhere
        EXPECT_EQ(channel.floats.empty() ? static_cast<float>(channel.integers[0])
                                         : channel.floats[0], 0) << name;
}

TEST_F(RenderFiles, OnlyWhatIsAskedIsInTheExr) {
    RenderConfig c = config("x.exr");
    c.aov = {"depth", "k1"};
    run(c);
    const ExrImage image = read_exr(file("x.exr"));
    EXPECT_EQ(image.channels.size(), 3u);
    EXPECT_TRUE(image.channels.contains("Z"));
    EXPECT_TRUE(image.channels.contains("curvature.k1"));
}

// CONVENTIONS 1.1: no hit is A = 0, in files without a colour too.
TEST_F(RenderFiles, AnExrOfDataAloneTellsBackgroundFromZero) {
    RenderConfig c = config("x.exr");
    c.aov = {"mean", "depth"};
    run(c);
    const ExrImage image = read_exr(file("x.exr"));
    const auto& a = image.channels.at("A").floats;
    const auto& depth = image.channels.at("Z").floats;
    ASSERT_EQ(a.size(), depth.size());
    for (std::size_t i = 0; i < a.size(); ++i) ASSERT_EQ(a[i], depth[i] > 0 ? 1 : 0) << i;
    EXPECT_GT(std::count(a.begin(), a.end(), 1), 100);
    EXPECT_GT(std::count(a.begin(), a.end(), 0), 100);
}

TEST_F(RenderFiles, DataAreNotAveragedButColourIs) {
    RenderConfig c = config("x.exr");
    c.aov = {"shaded", "id", "position"};
    run(c);
    const ExrImage once = read_exr(file("x.exr"));
    c.output = file("y.exr");
    c.supersample = 2;
    run(c);
    const ExrImage twice = read_exr(file("y.exr"));
    EXPECT_EQ(once.width, twice.width);
    EXPECT_EQ(once.channels.at("surfel.id").integers, twice.channels.at("surfel.id").integers);
    EXPECT_EQ(once.channels.at("P.X").floats, twice.channels.at("P.X").floats);
    const auto fractional = [](const ExrImage& image) {
        const auto& a = image.channels.at("A").floats;
        return std::count_if(a.begin(), a.end(), [](float v) { return v > 0 && v < 1; });
    };
    EXPECT_EQ(fractional(once), 0);
    EXPECT_GT(fractional(twice), 20);
}

TEST_F(RenderFiles, MetadataSayHowThePictureWasMade) {
    RenderConfig c = config("x.exr");
    c.aov = {"mean"};
    c.unit = "mm";
    c.range = {"2.5"};
    run(c);
    const ExrImage image = read_exr(file("x.exr"));
    EXPECT_EQ(image.metadata.at("slim:units"), "mm");
    EXPECT_EQ(image.metadata.at("slim:origin"), "0 0 0");
    EXPECT_NE(image.metadata.at("slim:camera").find("fov 35"), std::string::npos);
    EXPECT_NE(image.metadata.at("slim:config").find("unit"), std::string::npos);
    EXPECT_EQ(image.metadata.at("Software").substr(0, 5), "slim ");
    EXPECT_EQ(image.metadata.at("slim:config").find(folder_.string()), std::string::npos);
    EXPECT_FALSE(image.metadata.contains("capDate"));
    const PngImage preview = read_png(file("x.png"));
    EXPECT_EQ(preview.metadata.at("slim:range.mean"), "-2.5 2.5");
    EXPECT_EQ(image.metadata.at("slim:range.mean"), "-2.5 2.5");
    EXPECT_EQ(image.metadata.at("slim:configHash"), hash_text(image.metadata.at("slim:config")));
}

TEST_F(RenderFiles, MatricesMapPToItsPixel) {
    for (const bool ortho : {false, true}) {
        RenderConfig c = config("x.exr");
        c.aov = {"position", "depth"};
        c.camera = "iso";
        c.ortho = ortho;
        run(c, true);
        const ExrImage image = read_exr(file("x.exr"));
        const std::size_t i = 25 * 80 + 44;
        const auto& channels = image.channels;
        const double p[4] = {channels.at("P.X").floats[i], channels.at("P.Y").floats[i],
                             channels.at("P.Z").floats[i], 1};
        const auto mapped = [&](const char* name, std::size_t column) {
            double sum = 0;
            for (std::size_t row = 0; row < 4; ++row)
                sum += p[row] * image.matrices.at(name)[4 * row + column];
            return sum;
        };
        const double w = mapped("worldToNDC", 3);
        EXPECT_NEAR(mapped("worldToNDC", 0) / w * 80, 44.5, 1e-3);
        EXPECT_NEAR(mapped("worldToNDC", 1) / w * 60, 25.5, 1e-3);
        // The same in [-1, 1], y upwards.
        EXPECT_NEAR(mapped("worldToScreen", 0) / mapped("worldToScreen", 3), 2 * 44.5 / 80 - 1,
                    1e-4);
        EXPECT_NEAR(mapped("worldToScreen", 1) / mapped("worldToScreen", 3), 1 - 2 * 25.5 / 60,
                    1e-4);
        EXPECT_NEAR(-mapped("worldToCamera", 2), channels.at("Z").floats[i], 1e-4);
    }
}

TEST_F(RenderFiles, TheClockComesFromTheEnvironmentOnly) {
    setenv("SOURCE_DATE_EPOCH", "1122804000", 1);
    run(config("x.exr"));
    unsetenv("SOURCE_DATE_EPOCH");
    EXPECT_EQ(read_exr(file("x.exr")).metadata.at("capDate"), "2005:07:31 10:00:00");
    setenv("SOURCE_DATE_EPOCH", "soon", 1);
    EXPECT_THROW(run(config("y.exr")), ConfigError);
    unsetenv("SOURCE_DATE_EPOCH");
}

TEST_F(RenderFiles, AFolderInTheWayIsRefusedBeforeTheFirstPictureOfAFilm) {
    for (const char* name : {"film.mean.legend.svg", "film_0003.png"}) {
        std::filesystem::create_directory(file(name));
        RenderConfig c = config("film.png");
        c.aov = {"mean"}, c.turntable = 3;
        try {
            run(c);
            ADD_FAILURE() << name;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::usage);
            EXPECT_NE(std::string(error.what()).find(std::string(name) + ": is a folder"),
                      std::string::npos)
                << error.what();
        }
        EXPECT_FALSE(exists("film_0001.png"));
        std::filesystem::remove(file(name));
    }
}

TEST_F(RenderFiles, LinesBelowAFileAreRefusedBeforeThePicture) {
    std::ofstream(file("a_file")) << "x";
    for (const char* name : {"a_file/x.obj", "a_file/y/x.obj"}) {
        RenderConfig c = config("x.png");
        c.lines = {"contour"}, c.lines_obj = file(name);
        try {
            run(c);
            ADD_FAILURE() << name;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::usage);
            EXPECT_NE(std::string(error.what()).find("a_file is no folder"), std::string::npos)
                << error.what();
        }
        EXPECT_FALSE(exists("x.png"));
    }
    RenderConfig c = config("x.png");
    c.lines = {"contour"}, c.lines_obj = file("new/y/x.obj");
    run(c);
    EXPECT_TRUE(exists("new/y/x.obj"));
}

}  // namespace
}  // namespace slim
