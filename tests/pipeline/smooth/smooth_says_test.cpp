#include "tests/pipeline/smooth/smooth_stage_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

namespace slim::test {
namespace {

TEST_F(SmoothStage, MistakesAreRefusedByTheirCode) {
    const std::string cloud = noisy("sphere", 0.003);
    SmoothConfig c;
    c.output = cloud;
    EXPECT_EQ(code_of([&] { smooth(cloud, c); }), ExitCode::usage);
    c.output = file("x.xyz");
    EXPECT_EQ(code_of([&] { smooth(cloud, c); }), ExitCode::usage);
    EXPECT_EQ(code_of([&] {
                  smooth(folder_.write("bad.ply", "ply\nformat ascii 1.0\nelement vertex 2\n"));
              }),
              ExitCode::bad_data);
    c.output = file("x.xyz");
    EXPECT_EQ(code_of([&] { smooth(folder_.write("nan.xyz", "nan 0 0\n"), c); }),
              ExitCode::bad_data);
    const std::string face =
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty "
        "float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 1\n";
    EXPECT_EQ(code_of([&] { smooth(folder_.write("face.ply", face + "3 0 0 5\n")); }),
              ExitCode::bad_data);
    EXPECT_NE(message_.find("vertex index 5"), std::string::npos) << message_;
    EXPECT_FALSE(std::filesystem::exists(file("smooth.ply")));
}

TEST_F(SmoothStage, SaysWhereMostLeavesAreKeptWithoutAlarm) {
    const std::string cloud = write(sampled("torus", 20000, 1, 3e-6), "c.ply");
    build(build_config(cloud, "m.slim"));
    listener_.warnings.clear(), listener_.infos.clear();
    const auto said = smooth(cloud);
    EXPECT_GT(said["leaves_kept"], said["leaves_refitted"]);
    EXPECT_EQ(listener_.warnings.size(), 0u);
    ASSERT_EQ(listener_.infos.size(), 1u);
    EXPECT_NE(listener_.infos[0].find("went only part of the way"), std::string::npos)
        << listener_.infos[0];
    EXPECT_NE(listener_.infos[0].find("max_displacement"), std::string::npos) << listener_.infos[0];
    EXPECT_GT(2 * said["points_held_back"].get<int>(), said["moved"]);
    EXPECT_LT(said["noise"], 3e-5);
    EXPECT_EQ(said["leaves_noise_unknown"], 0);
    // Where none is to go anywhere, none goes part of the way.
    SmoothConfig stay;
    stay.amount = 0;
    listener_.infos.clear();
    smooth(cloud, stay);
    EXPECT_TRUE(listener_.infos.empty()) << listener_.infos[0];
}

TEST_F(SmoothStage, SaysNothingOfPointsHeldBackWhereMostGoAllTheWay) {
    const std::string cloud = noisy("torus", 0.003);
    listener_.warnings.clear(), listener_.infos.clear();
    const auto said = smooth(cloud);
    EXPECT_LT(2 * said["points_held_back"].get<int>(), said["moved"]);
    EXPECT_TRUE(listener_.infos.empty()) << listener_.infos[0];
    EXPECT_NEAR(said["noise"].get<double>(), 0.003, 0.0006);  // over L, as it was made
}

TEST_F(SmoothStage, WarnsWherePointsAreTooFewToTellNoise) {
    const std::string cloud = write(sampled("sphere", 20), "c.ply");
    build(build_config(cloud, "m.slim"));
    listener_.warnings.clear();
    const auto said = smooth(cloud);
    EXPECT_TRUE(said["noise"].is_null());
    EXPECT_GT(said["leaves_noise_unknown"], 0);
    ASSERT_EQ(listener_.warnings.size(), 1u);
    EXPECT_NE(listener_.warnings[0].find("too few points to tell noise from shape"),
              std::string::npos)
        << listener_.warnings[0];
}

TEST_F(SmoothStage, LittleMemoryMeansAShareOfThePoints) {
    const Cloud dense = sampled("torus", 200000, 1, 0.003);
    const std::string cloud = write(dense, "dense.ply");
    build(build_config(cloud, "m.slim"));
    const auto whole = smooth(cloud);
    EXPECT_EQ(whole["refit_share"], 1);
    EXPECT_EQ(whole["leaves_kept_for_memory"], 0);
    const double by_all = rms_distance("torus", read_all(file("smooth.ply"), 200000).position);
    SmoothConfig c;
    c.memory = "64MiB";
    listener_.warnings.clear();
    const auto part = smooth(cloud, c);
    ASSERT_EQ(listener_.warnings.size(), 1u);
    EXPECT_NE(listener_.warnings[0].find("of the points are fitted to, for memory (64MiB)"),
              std::string::npos);
    EXPECT_LE(part["refit_share"], 0.5);
    EXPECT_EQ(part["moved"], 200000);
    const double by_part = rms_distance("torus", read_all(file("smooth.ply"), 200000).position);
    EXPECT_GT(by_part, by_all);
    EXPECT_LT(by_part, 2.2 * by_all);  // a quarter of the points: twice the error at most
}

TEST_F(SmoothStage, MoreLeavesThanMemoryHoldsAreTakenAsTheyAre) {
    const std::string cloud = write(sampled("bumpy", 200000, 1, 1e-6), "c.ply");
    BuildConfig b = build_config(cloud, "m.slim");
    b.t_mdl = 1e-5;
    const auto built = build(b);
    ASSERT_GT(built["leaves"], 17000);
    listener_.warnings.clear();
    SmoothConfig c;
    c.memory = "64MiB";
    const auto said = smooth(cloud, c);
    EXPECT_EQ(said["leaves_refitted"], 0);
    EXPECT_EQ(said["leaves_kept_for_memory"], built["leaves"]);
    EXPECT_EQ(said["moved"], 200000);
    ASSERT_GE(listener_.warnings.size(), 1u);
    EXPECT_NE(listener_.warnings[0].find("--memory"), std::string::npos);
    for (const std::string& warning : listener_.warnings)  // nothing is
        EXPECT_EQ(warning.find("are fitted to"), std::string::npos) << warning;
    EXPECT_GT(said["points_held_back"], 0);  // none without shares
    EXPECT_LT(rms_distance("bumpy", read_all(file("smooth.ply"), 200000).position),
              1.05 * rms_distance("bumpy", read_all(cloud, 200000).position));
    c.memory = "63MiB";
    EXPECT_EQ(code_of([&] { smooth(cloud, c); }), ExitCode::usage);
}

TEST_F(SmoothStage, WarnsWhereMostOfTheCloudLiesElsewhere) {
    Cloud cloud = sampled("sphere", 3000);
    build(build_config(write(cloud, "c.ply"), "m.slim"));
    for (std::size_t i = 10; i < cloud.size(); ++i) cloud.positions[i] += Vec3d{10, 0, 0};
    listener_.warnings.clear();
    EXPECT_EQ(smooth(write(cloud, "away.ply"))["moved"], 10);
    ASSERT_EQ(listener_.warnings.size(), 1u);
}

TEST_F(SmoothStage, ACloudInAnotherFrameIsRefusedAndNothingIsWritten) {
    Cloud cloud = sampled("sphere", 3000);
    build(build_config(write(cloud, "c.ply"), "m.slim"));
    for (Vec3d& p : cloud.positions) p += Vec3d{10, 0, 0};
    cloud.positions[0].x = NAN;
    const std::string away = write(cloud, "away.ply");
    EXPECT_EQ(code_of([&] { smooth(away); }), ExitCode::numerical);
    for (const char* said : {"m.slim", "away.ply", "2999 points", "same frame?"})
        EXPECT_NE(message_.find(said), std::string::npos) << said << " in " << message_;
    for (const char* name : {"smooth.ply", "smooth.ply.done.json"})
        EXPECT_FALSE(std::filesystem::exists(file(name))) << name;
}

}  // namespace
}  // namespace slim::test
