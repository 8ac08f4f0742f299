#include "pipeline/build/build_stage.h"

#include "pipeline/build/build_summary.h"
#include "pipeline/info/info_stage.h"
#include "tests/pipeline/build/build_stage_support.h"
#include "tests/pipeline/build/fit_stages_support.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <tuple>

namespace slim::test {
namespace {

TEST_F(BuildStage, KeptNormalsTakeNoSensors) {
    BuildConfig c = build_config(write(sampled("sphere", 3000), "c.ply"), "m.slim");
    c.normals = "keep", c.sensors = file("c.scans.json");
    EXPECT_EQ(code_of([&] { build(c); }), ExitCode::usage);
    EXPECT_NE(message_.find("sensors"), std::string::npos) << message_;
}

TEST_F(BuildStage, EveryOptionCounts) {
    const std::string cloud = scanned_sphere(5000);
    build(build_config(cloud, "plain.slim"));
    const std::string plain = read_bytes(file("plain.slim"));
    const auto bytes_with = [&](auto&& change) {
        auto config = build_config(cloud, "other.slim");
        change(config);
        build(config);
        return read_bytes(file("other.slim"));
    };
    EXPECT_EQ(bytes_with([](BuildConfig&) {}), plain);
    EXPECT_NE(bytes_with([](BuildConfig& c) { c.degree = "3"; }), plain);
    EXPECT_NE(bytes_with([](BuildConfig& c) { c.degree = "auto"; }), plain);
    EXPECT_NE(bytes_with([](BuildConfig& c) { c.radius_rule = "windows"; }), plain);
    EXPECT_NE(bytes_with([](BuildConfig& c) { c.weight = "polynomial"; }), plain);
    for (const char* cover : {"A", "C"})
        EXPECT_NE(bytes_with([&](BuildConfig& c) { c.cover = cover; }), plain);
    EXPECT_NE(bytes_with([](BuildConfig& c) { c.lambda = 1e-5; }), plain);
    EXPECT_NE(bytes_with([](BuildConfig& c) { c.normals = "estimate"; }), plain);
    EXPECT_NE(bytes_with([](BuildConfig& c) { c.seed = 1; }), plain);
    EXPECT_NE(bytes_with([](BuildConfig& c) { c.slices = 2; }), plain);
}

TEST_F(BuildStage, TheModelSaysWhatItWasFittedWith) {
    const std::string cloud = scanned_sphere(5000);
    const auto info_of = [&](const BuildConfig& config) {
        build(config);
        InfoConfig info;
        info.file = config.output;
        Reporter silent;
        return run_as("info", info, run_info, silent);
    };
    auto config = build_config(cloud, "m.slim");
    const auto plain = info_of(config);
    EXPECT_EQ(plain["fit"].dump(),
              R"({"cover":"B","degree":2,"edge_places":96,"edge_share":0.0,"radius_rule":"ladder",)"
              R"("sharp":false,"weight":"gauss"})");
    config.sharp = "off";
    config.degree = "auto";
    config.weight = "polynomial";
    config.cover = "C";
    EXPECT_EQ(info_of(config)["fit"].dump(),
              R"({"cover":"C","degree":"auto","radius_rule":"ladder","sharp":false,)"
              R"("weight":"polynomial"})");
    config.degree = "3";
    config.radius_rule = "windows";
    EXPECT_EQ(info_of(config)["fit"]["radius_rule"], "windows");
}

TEST_F(BuildStage, NormalsBetterThanThePointsMakeCurvatureBetter) {
    const std::string cloud = write(sampled("bumpy", 30000, 1, 1e-3), "bumpy.ply");
    auto config = build_config(cloud, "m.slim");
    config.degree = "3";
    build(config);
    const auto followed = measure(config.output, cloud);
    config.normals = "estimate";
    build(config);
    const auto alone = measure(config.output, cloud);
    for (const char* key : {"normal_rms_deg", "k1_rms", "k2_rms", "mean_curvature_rms"})
        EXPECT_LT(followed[key].get<double>(), 0.5 * alone[key].get<double>()) << key;
    EXPECT_LT(followed["l2"].get<double>(), 1.05 * alone["l2"].get<double>());
}

TEST_F(BuildStage, NoiseSaysWhatEdgesMakeOfIt) {
    const auto said = [&](const std::string& cloud) {
        const auto config = build_config(cloud, "m.slim");
        const auto result = build(config);
        InfoConfig info;
        info.file = config.output;
        Reporter silent;
        const auto model = run_as("info", info, run_info, silent);
        return std::tuple(model["noise"].get<double>(), model["noise_typical"].get<double>(),
                          build_summary(config.output, config.inputs, result));
    };
    const auto [of_cube, typical_of_cube, cube] =
        said(folder_.write("cube.xyz", cube_text(40)));
    EXPECT_GT(of_cube, 1e-3);
    EXPECT_LT(typical_of_cube, 1e-6);
    EXPECT_NE(cube.find(" (of edges and bends; "), std::string::npos) << cube;
    const auto [of_noisy, typical_of_noisy, noisy] =
        said(write(sampled("sphere", 20000, 1, 3e-3), "noisy.ply"));
    EXPECT_NEAR(typical_of_noisy, of_noisy, 0.3 * of_noisy);
    EXPECT_EQ(noisy.find("edges and bends"), std::string::npos) << noisy;
    // What --lambda says is nobody's measurement.
    auto config = build_config(file("cube.xyz"), "m.slim");
    config.lambda = 1e-4;
    const auto told = build_summary(config.output, config.inputs, build(config));
    EXPECT_EQ(told.find("edges and bends"), std::string::npos) << told;
}

TEST_F(BuildStage, EveryLeafOfALowerDegreeHasACause) {
    // A cube's corners, a scan with noise: forced leaves, too few points, contrary normals.
    const std::string cube = folder_.write("cube.xyz", cube_text(24));
    const std::string noisy = write(sampled("bumpy", 3000, 1, 5e-3), "noisy.ply");
    for (const std::string& cloud : {cube, noisy})
        for (const int slices : {1, 3}) {
            SCOPED_TRACE(testing::Message() << cloud << ", slices " << slices);
            auto config = build_config(cloud, "m.slim");
            config.degree = "3";
            config.sharp = "off";  // sheets choose planes of their own accord
            config.slices = slices;
            build(config);
            InfoConfig info;
            info.file = config.output;
            Reporter silent;
            const auto found = run_as("info", info, run_info, silent);
            std::uint64_t lower = 0, causes = 0;
            for (const auto& [degree, n] : found["leaves_by_degree"].items())
                if (degree != "3") lower += n.get<std::uint64_t>();
            for (const char* cause : {"few_points", "rank", "steep", "plane", "lower_explains"})
                causes += found["fallbacks"].at(cause).get<std::uint64_t>();
            EXPECT_EQ(causes, lower);
            if (cloud == cube) {
                EXPECT_GT(found["fallbacks"].at("contrary").get<int>(), 0);
                EXPECT_GT(lower, 0u);
            }
        }
}

TEST_F(BuildStage, WindowsRefuseWhatTheyDoNotKnow) {
    const std::string cloud = scanned_sphere(500);
    auto config = build_config(cloud, "m.slim");
    config.radius_rule = "windows";
    config.degree = "auto";
    EXPECT_THROW(build(config), ConfigError);
    config.degree = "2";
    config.sharp = "on";
    EXPECT_THROW(build(config), ConfigError);
    EXPECT_FALSE(std::filesystem::exists(file("m.slim.work")));  // refused before any work
}

}  // namespace
}  // namespace slim::test
