#include "formats/point_source.h"
#include "pipeline/build/build_stage.h"
#include "pipeline/info/info_stage.h"
#include "raytrace/picture.h"
#include "slim/base/error.h"
#include "tests/pipeline/render/render_test_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>

namespace slim {
namespace {

/// The colouring: linear in x, waves in y.
Vec3d color_at(const Vec3d& p) {
    return {0.5 + 0.4 * p.x, 0.5 + 0.3 * std::sin(3 * p.y), 0.3 + 0.2 * p.z * p.z};
}

class ModelColor : public test::RenderTest {
protected:
    /// 20,000 points of the unit sphere, moved to `origin`.
    void write_cloud(const std::string& name, const Vec3d& origin, bool colored = true) {
        constexpr std::size_t n = 20000;
        std::ofstream out(file(name));
        out << "ply\nformat ascii 1.0\nelement vertex " << n
            << "\nproperty double x\nproperty double y\nproperty double z\n"
            << "property float nx\nproperty float ny\nproperty float nz\n";
        if (colored) out << "property uchar red\nproperty uchar green\nproperty uchar blue\n";
        out << "end_header\n";
        out.precision(12);
        for (std::size_t i = 0; i < n; ++i) {
            const Vec3d p = test::fibonacci_point(i, n), c = color_at(p) * 255, at = p + origin;
            out << at.x << ' ' << at.y << ' ' << at.z << ' ' << p.x << ' ' << p.y << ' ' << p.z;
            if (colored)
                out << ' ' << std::lround(c.x) << ' ' << std::lround(c.y) << ' '
                    << std::lround(c.z);
            out << '\n';
        }
    }

    nlohmann::json build(const std::string& cloud, const std::string& model, bool color) {
        BuildConfig config;
        config.inputs = {file(cloud)};
        config.output = file(model);
        config.color = color;
        const FieldList fields = fields_of(config);
        StageContext context{
            reporter_, 1, true, "build", canonical_config(fields), print_config(fields), ""};
        return run_build(config, context);
    }
};

TEST_F(ModelColor, InfoSaysThatTheyAreReadWhereTheyAreAskedFor) {
    write_cloud("c.ply", {}), write_cloud("plain.ply", {}, false);
    const auto info = [&](const char* name) {
        StageContext context{reporter_, 1, true, "info", "", "", ""};
        return run_info({file(name)}, context);
    };
    EXPECT_EQ(info("c.ply")["colors"], "yes, read by slim build --color");
    EXPECT_EQ(info("c.ply")["skipped"], nlohmann::json::array());
    EXPECT_EQ(info("plain.ply")["colors"], "no");
}

TEST_F(ModelColor, APictureHasTheColoursOfTheCloud) {
    const Vec3d origin{400000, 5000000, 100};
    write_cloud("c.ply", origin);
    const auto result = build("c.ply", "m.slim", true);
    EXPECT_EQ(result["color"]["points"], 20000);
    EXPECT_EQ(result["color"]["lost"], 0);
    RenderConfig c = config("x.exr");
    c.aov = {"color", "position"}, c.size = "160x120";
    run(c);
    const ExrImage image = read_exr(c.output);
    // P is local to the model's origin.
    const Vec3d local = ModelFile::open(file("m.slim")).header().origin - origin;
    double sum = 0, worst = 0;
    int n = 0;
    for (std::size_t i = 0; i < 160 * 120; ++i) {
        if (image.channels.at("A").floats[i] == 0) continue;
        const Vec3d p{image.channels.at("P.X").floats[i], image.channels.at("P.Y").floats[i],
                      image.channels.at("P.Z").floats[i]};
        const Vec3d exact = color_at(p + local);
        const char* const names[] = {"R", "G", "B"};
        for (std::size_t channel = 0; channel < 3; ++channel) {
            const float shown = srgb_from_linear(image.channels.at(names[channel]).floats[i]);
            const double error = std::abs(static_cast<double>(shown) - exact[channel]);
            sum += error * error, worst = std::max(worst, error), ++n;
        }
    }
    EXPECT_GT(n, 10000);
    EXPECT_LT(std::sqrt(sum / n), 0.004);  // a step of 8 bits, and the bend of the waves in a leaf
    EXPECT_LT(worst, 0.02);
}

TEST_F(ModelColor, AModelWithoutItIsTheSameBytesAndSaysHowToGetIt) {
    write_cloud("c.ply", {});
    write_cloud("plain.ply", {}, false);
    build("c.ply", "without.slim", false);
    build("plain.ply", "plain.slim", false);
    // Apart from the origin of its points nothing tells them apart.
    EXPECT_EQ(bytes("without.slim"), bytes("plain.slim"));
    EXPECT_TRUE(ModelFile::open(file("without.slim")).colors().empty());
    RenderConfig c = config("x.png");
    c.model = file("without.slim"), c.aov = {"color"};
    try {
        run(c);
        FAIL();
    } catch (const ConfigError& error) {
        EXPECT_NE(std::string(error.what()).find("--color"), std::string::npos) << error.what();
    }
    try {
        build("plain.ply", "x.slim", true);
        FAIL();
    } catch (const DataError& error) {
        EXPECT_NE(std::string(error.what()).find("plain.ply"), std::string::npos) << error.what();
    }
    // Refused before the work, not after it.
    EXPECT_FALSE(std::filesystem::exists(file("x.slim")));
    EXPECT_FALSE(std::filesystem::exists(file("x.slim.work")));
    // All else of a model with colours is as without.
    build("c.ply", "with.slim", true);
    const ModelFile with = ModelFile::open(file("with.slim")),
                    without = ModelFile::open(file("without.slim"));
    EXPECT_TRUE(std::equal(with.tree().records().begin(), with.tree().records().end(),
                           without.tree().records().begin(), without.tree().records().end()));
    EXPECT_EQ(with.colors().size(), with.tree().n_nodes());
    EXPECT_NEAR(static_cast<double>(with.file_size() - without.file_size()),
                18.0 * static_cast<double>(with.tree().n_nodes()), 200);
}

TEST_F(ModelColor, TheyAreReadOnlyForPicturesThatShowThem) {
    write_cloud("c.ply", {});
    build("c.ply", "m.slim", true);
    const ModelFile model = ModelFile::open(file("m.slim"));
    const std::uint64_t n_colors = 18 * model.tree().n_nodes();
    EXPECT_EQ(model.colors_size(), n_colors);
    EXPECT_EQ(model.surface_size(), model.file_size() - n_colors);
    RenderConfig c = config("x.png");
    const auto bytes_read = [&](const std::string& aov) {
        c.aov = {aov};
        return run(c, true)["model_bytes_read"].get<std::uint64_t>();
    };
    for (const char* mode : {"forward", "raytrace"}) {
        c.mode = mode;
        EXPECT_EQ(bytes_read("shaded"), model.surface_size());
        EXPECT_EQ(bytes_read("mean"), model.surface_size());
        EXPECT_EQ(bytes_read("color"), model.file_size());
    }
    c.material = "color=scan specular=0";
    EXPECT_EQ(bytes_read("shaded"), model.file_size());
    c.material = "color=#808080";
    EXPECT_EQ(bytes_read("shaded"), model.surface_size());
    c.material.clear();
    // No byte of them is looked at otherwise, in further models of the scene neither.
    std::string damaged = bytes("m.slim");
    damaged[model.chunks().offset("colors") + n_colors / 2] ^= 1;
    std::ofstream(file("damaged.slim"), std::ios::binary) << damaged;
    c.add = {file("damaged.slim")};
    EXPECT_EQ(bytes_read("shaded"), model.surface_size());
    c.add = {}, c.mode = "forward", c.model = file("damaged.slim");
    EXPECT_EQ(bytes_read("shaded"), model.surface_size());
    EXPECT_THROW(bytes_read("color"), FormatError);
}

TEST_F(ModelColor, AMaterialOfTheScansColoursIsLit) {
    write_cloud("c.ply", {});
    build("c.ply", "m.slim", true);
    RenderConfig c = config("x.exr");
    c.size = "120x100";
    const auto picture = [&](const std::string& aov, const std::string& material) {
        c.aov = {aov}, c.material = material;
        c.light = aov == "color" ? RenderConfig{}.light : "sun azimuth=40 elevation=30; fill";
        run(c, true);
        return read_exr(file("x.exr"));
    };
    for (const char* mode : {"forward", "raytrace"}) {
        c.mode = mode;
        const ExrImage colors = picture("color", ""),
                       white = picture("shaded", "color=#ffffff specular=0"),
                       lit = picture("shaded", "color=scan specular=0");
        std::size_t hits = 0;
        for (const char* channel : {"R", "G", "B"}) {
            const auto& a = colors.channels.at(channel).floats;
            const auto& b = white.channels.at(channel).floats;
            const auto& x = lit.channels.at(channel).floats;
            ASSERT_EQ(a.size(), x.size());
            for (std::size_t i = 0; i < x.size(); ++i) {
                // Halves have 11 bits.
                EXPECT_NEAR(x[i], a[i] * b[i], 0.002f * (a[i] * b[i] + 0.01f)) << mode << channel;
                hits += x[i] > 0;
            }
        }
        EXPECT_GT(hits, 3u * 120 * 100 / 4) << mode;
        // Edges with more samples are means of the colours, too.
        c.output = file("x.png"), c.antialias = true;
        EXPECT_GT(run(c, true)["antialiased_pixels"], 100) << mode;
        c.output = file("x.exr"), c.antialias = false;
    }
}

TEST_F(ModelColor, AMaterialOfTheScansColoursIsRefusedWhereThereAreNone) {
    write_cloud("plain.ply", {}, false), write_cloud("c.ply", {});
    build("plain.ply", "plain.slim", false), build("c.ply", "m.slim", true);
    const auto message = [&](const std::string& model, const std::string& material,
                             const std::string& add) {
        RenderConfig c = config("x.png");
        c.model = file(model), c.material = material, c.mode = "raytrace";
        if (!add.empty()) c.add = {file(add)};
        try {
            run(c, true);
        } catch (const ConfigError& error) {
            return std::string(error.what());
        }
        return std::string("accepted");
    };
    EXPECT_NE(message("plain.slim", "color=scan", "").find("--color"), std::string::npos);
    EXPECT_NE(message("m.slim", "color=scan mirror=0.5", "").find("mirror"), std::string::npos);
    EXPECT_NE(message("m.slim", "color=scan", "plain.slim").find("add"), std::string::npos);
    EXPECT_EQ(message("m.slim", "color=scan", ""), "accepted");
    EXPECT_EQ(message("m.slim", "color=#aabbcc", "plain.slim"), "accepted");
}

TEST_F(ModelColor, ColoursOfAllTypesAreRead) {
    const std::pair<const char*, const char*> cases[] = {
        {"uchar", "255 0 51"}, {"ushort", "65535 0 13107"}, {"float", "1 0 0.2"}};
    for (const auto& [type, values] : cases)
        for (const char* prefix : {"", "diffuse_"}) {
            std::ofstream out(file("c.ply"));
            out << "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float "
                   "y\nproperty float z\n";
            for (const char* name : {"red", "green", "blue"})
                out << "property " << type << ' ' << prefix << name << '\n';
            out << "end_header\n1 2 3 " << values << '\n';
            out.close();
            const auto source = open_colored_cloud(file("c.ply"));
            ASSERT_TRUE(source) << type;
            PointChunk chunk;
            ASSERT_TRUE(source->read(chunk, 10));
            EXPECT_NEAR(chunk.color[0].x, 1, 1e-6) << type;
            EXPECT_NEAR(chunk.color[0].y, 0, 1e-6) << type;
            EXPECT_NEAR(chunk.color[0].z, 0.2f, 1e-6) << type;
        }
    write_cloud("plain.ply", {}, false);
    EXPECT_FALSE(open_colored_cloud(file("plain.ply")));
}

}  // namespace
}  // namespace slim
