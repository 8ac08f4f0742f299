#include "formats/model_file.h"
#include "pipeline/render/render_stage.h"
#include "tests/pipeline/build/fit_stages_support.h"
#include "tests/pipeline/extremes_support.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

// NUMERICS section 6, rows of points that make no cloud as they stand: extremes_test.cpp.

namespace slim::test {
namespace {

namespace fs = std::filesystem;

/// n points of one place.
Cloud cloud_at(const Vec3d& place, std::size_t n) {
    Cloud cloud;
    cloud.positions.assign(n, place);
    cloud.normals.assign(n, {0, 0, 1});
    return cloud;
}

TEST_F(Extremes, Row06AllPointsInOnePlaceAreRefusedWithTheReason) {
    for (const std::size_t n : {2u, 3u, 1000u}) {
        SCOPED_TRACE(n);
        const std::string same = write_text("same.xyz", std::vector<Vec3d>(n, {1, 2, 3}));
        EXPECT_EQ(code_of([&] { built(same); }), ExitCode::bad_data);
        EXPECT_NE(message_.find("same.xyz"), std::string::npos) << message_;
        EXPECT_NE(message_.find("do not coincide"), std::string::npos) << message_;
        EXPECT_NE(message_.find(": " + std::to_string(n) + " points within"), std::string::npos)
            << message_;
        const std::string floats = write_floats("same.ply", cloud_at({1, 2, 3}, n));
        EXPECT_EQ(code_of([&] { built(floats); }), ExitCode::bad_data);
        EXPECT_FALSE(warned_of("finer detail"));
        EXPECT_TRUE(warned_of("stored at one place"));
    }
    const std::string one = write_text("one.xyz", std::vector<Vec3d>(1, {1, 2, 3}));
    EXPECT_EQ(code_of([&] { built(one); }), ExitCode::bad_data);
    EXPECT_NE(message_.find(": 1 point within"), std::string::npos) << message_;
    listener_.warnings.clear();
    const std::string floats =
        folder_.write("one.ply",
                      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                      "property float y\nproperty float z\nend_header\n9 8 7\n");
    EXPECT_EQ(code_of([&] { built(floats); }), ExitCode::bad_data);
    EXPECT_FALSE(warned_of("finer detail"));  // there is none
}

TEST_F(Extremes, Row07CopiesOfAFewPointsAreTheUniqueSet) {
    for (const auto& [n, copies] : {std::pair{60, 12}, {150, 6}, {4, 20}}) {
        SCOPED_TRACE(testing::Message() << n << " x " << copies);
        const Cloud cloud = sampled("sphere", static_cast<std::size_t>(n));
        Cloud all;
        for (int i = 0; i < copies; ++i) append(all, cloud);
        build(build_config(write(cloud, "once.ply"), "once.slim"));
        const auto result = build(build_config(write(all, "often.ply"), "often.slim"));
        EXPECT_EQ(result.at("stages").at("fit").at("copies"),
                  static_cast<std::uint64_t>(n * (copies - 1)));
        const auto once = measure(file("once.slim"), file("once.ply"));
        const auto often = measure(file("often.slim"), file("once.ply"));
        EXPECT_EQ(often.at("leaves"), once.at("leaves"));
        EXPECT_EQ(often.at("missed"), once.at("missed"));
        EXPECT_NEAR(often.at("l2").get<double>(), once.at("l2").get<double>(),
                    0.02 * once.at("l2").get<double>());
    }
}

TEST_F(Extremes, Row08OneOrTwoScanLinesMakeDiscsAndPlanesAndSaySo) {
    for (const int lines : {1, 2}) {
        SCOPED_TRACE(lines);
        std::vector<Vec3d> points;
        for (int i = 0; i < 600; ++i)
            points.push_back({i / 300.0, 0.05 * (i % lines), 0.3 * i / 600});
        const auto fit = fit_of(built(write_text("lines.xyz", points)));
        const std::uint64_t leaves = fit["leaves"];
        EXPECT_GT(leaves, 0u);
        EXPECT_EQ(
            fit["degrees"]["0"].get<std::uint64_t>() + fit["degrees"]["1"].get<std::uint64_t>(),
            leaves);
        std::uint64_t causes = 0;
        for (const auto& [cause, count] : fit["fallbacks"].items())
            causes += count.get<std::uint64_t>();
        // A forced leaf takes the lowest degree that explains it: that is no fallback.
        EXPECT_GE(causes + fit["forced"].get<std::uint64_t>(), leaves);
    }
}

TEST_F(Extremes, Row29NonFinitePointsAreDroppedAndCountedOrRefused) {
    Cloud cloud = sampled("sphere", 5000);
    built(write(cloud, "clean.ply"), "clean.slim");
    cloud.positions[100].x = NAN, cloud.positions[2000].y = INFINITY,
    cloud.positions[4999].z = -INFINITY;
    BuildConfig config = build_config(write(cloud, "bad.ply"), "m.slim");
    const auto result = build(config);
    EXPECT_EQ(result["stages"]["slice"]["dropped"], 3);
    EXPECT_EQ(result["points"], 4997);
    EXPECT_TRUE(warned_of("3 of 5000 points are not finite"));
    EXPECT_NEAR(result["leaves"].get<double>() /
                    static_cast<double>(ModelFile::open(file("clean.slim")).header().n_leaves),
                1, 0.1);
    config.strict = true;
    EXPECT_EQ(code_of([&] { build(config); }), ExitCode::bad_data);
    EXPECT_NE(message_.find("bad.ply: point 101"), std::string::npos) << message_;
}

TEST_F(Extremes, Row30NoPointsAreRefusedWithTheFile) {
    for (const char* text : {"# only a comment\n", "nan nan nan\n", ""}) {
        const std::string empty = folder_.write("empty.xyz", text);
        EXPECT_EQ(code_of([&] { built(empty); }), ExitCode::bad_data);
        EXPECT_NE(message_.find("empty.xyz"), std::string::npos) << message_;
        EXPECT_FALSE(fs::exists(file("m.slim")));
    }
}

TEST_F(Extremes, Row31AFewPointsMakeAModelThatRenders) {
    const std::vector<Vec3d> points{{0, 0, 0},   {2, 0, 0}, {0, 2, 0}, {1, 0, 0}, {0, 1, 0},
                                    {1, 1, 0.1}, {2, 1, 0}, {1, 2, 0}, {2, 2, 0}};
    for (const std::size_t n : {1u, 2u, 3u, 9u}) {
        SCOPED_TRACE(n);
        const std::string cloud =
            write_text("few.xyz", {points.begin(), points.begin() + static_cast<long>(n)});
        if (n < 3) {  // no surface: the other outcome that the row's sense allows
            EXPECT_EQ(code_of([&] { built(cloud); }), ExitCode::bad_data);
            EXPECT_NE(message_.find("at least 3 points"), std::string::npos) << message_;
            continue;
        }
        const auto result = built(cloud);
        EXPECT_EQ(fit_of(result)["degrees"]["2"], 0);
        EXPECT_EQ(result["leaves"], n == 3 ? 1 : 2);
        EXPECT_EQ(result["dropped"], 0);
        const auto measured = measure(file("m.slim"), cloud);
        EXPECT_EQ(measured["missed"], 0);
        // Eight of the nine lie in a plane, the middle one 0.035 L off it.
        EXPECT_LT(measured["max"].get<double>(), n == 3 ? 1e-7 : 0.03);
        RenderConfig render;
        render.model = file("m.slim");
        render.output = file("few.png");
        render.size = "64x64";
        render.camera = "front";  // along -z
        const auto drawn =
            run_as("render", render, run_render, listener_);  // throws if nothing is hit
        EXPECT_TRUE(fs::exists(file("few.png"))) << drawn.dump();
    }
}

TEST_F(Extremes, Row32HugeAndDenormalCoordinatesAreRefusedWithTheirBox) {
    const auto refusal = [&](double scale) {
        std::vector<Vec3d> points;
        for (const Vec3d& p : sampled("sphere", 50).positions) points.push_back(p * scale);
        const std::string cloud = write_text("extreme.xyz", points);
        EXPECT_EQ(code_of([&] { built(cloud); }), ExitCode::bad_data) << scale;
        EXPECT_NE(message_.find("extreme.xyz"), std::string::npos) << message_;
        return message_;
    };
    for (const double huge : {1e200, 1e308}) {  // the square of 1e200 is no double
        EXPECT_NE(refusal(huge).find("overflows"), std::string::npos);
        EXPECT_NE(message_.find("from ("), std::string::npos) << message_;
    }
    for (const double scale : {1e100, 1e-100})
        EXPECT_NE(refusal(scale).find("the cloud's diagonal is"), std::string::npos);
    EXPECT_NE(refusal(1e-310).find("change its unit"), std::string::npos)
        << message_;  // its square is none
    // A denormal coordinate beside ordinary ones is as good as zero.
    Cloud cloud = sampled("plane", 2000);
    for (std::size_t i = 0; i < cloud.size(); ++i)
        cloud.positions[i].z = i % 2 == 0 ? 4e-320 : -4e-320;
    EXPECT_GT(built(write(cloud, "plane.ply"))["leaves"].get<int>(), 0);
}

}  // namespace
}  // namespace slim::test
