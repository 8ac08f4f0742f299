#include "slim/base/parallel.h"
#include "slim/smooth/smoothing.h"
#include "tests/pipeline/smooth/smooth_stage_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

namespace slim::test {
namespace {

TEST_F(SmoothStage, TakesMostOfTheNoiseOffKnownShapes) {
    // Measured ratios: see the README's table; 100,000 points give more.
    for (const char* shape : {"sphere", "torus", "bumpy"}) {
        SCOPED_TRACE(shape);
        const std::string cloud = noisy(shape, 0.003);
        const auto said = smooth(cloud);
        EXPECT_EQ(said["points"], 20000);
        EXPECT_EQ(said["moved"], 20000);
        EXPECT_GT(said["leaves_refitted"], said["leaves_kept"]);
        EXPECT_LT(said["points_by_model"], 20);
        EXPECT_LT(said["points_held_back"], 1500);
        const double before = rms_distance(shape, read_all(cloud, 20000).position);
        const double after = rms_distance(shape, read_all(file("smooth.ply"), 20000).position);
        EXPECT_LT(after, before / 6.5);
        EXPECT_NEAR(said["rms_displacement"].get<double>() / before, 1, 0.1);
        EXPECT_GE(said["max_displacement"].get<double>(), said["rms_displacement"].get<double>());
    }
}

TEST_F(SmoothStage, NormalsAreTheSurfacesAndOrderAndAttributesStay) {
    const std::string cloud = noisy("sphere", 0.003);
    smooth(cloud);
    const PointChunk before = read_all(cloud, 20000), after = read_all(file("smooth.ply"), 20000);
    ASSERT_EQ(after.size(), before.size());
    EXPECT_EQ(after.scan, before.scan);
    double sum = 0;
    for (std::size_t i = 0; i < after.size(); ++i) {
        ASSERT_LT(length(after.position[i] - before.position[i]), 0.1);
        sum += std::acos(
            std::min(1.0, dot(to_double(after.normal[i]), normalized(after.position[i]))));
    }
    EXPECT_LT(sum / 20000, 0.02);  // radians
}

TEST_F(SmoothStage, WithoutNormalsPointsGoAlongTheModelsAndGetThem) {
    const std::string cloud = noisy("sphere", 0.003, false);
    const auto said = smooth(cloud);
    EXPECT_EQ(said["moved"], 20000);
    const PointChunk after = read_all(file("smooth.ply"), 20000);
    EXPECT_LT(rms_distance("sphere", after.position), 0.0104 / 5);
    ASSERT_EQ(after.normal.size(), after.size());
    EXPECT_GT(dot(to_double(after.normal[7]), after.position[7]), 0.99);
}

TEST_F(SmoothStage, PointsWithoutSupportStayAndAreCounted) {
    Cloud cloud = sampled("sphere", 5000);
    build(build_config(write(cloud, "c.ply"), "m.slim"));
    cloud.positions[10] = {50, 60, 70};
    cloud.positions[20].x = NAN;
    const auto said = smooth(write(cloud, "strays.ply"));
    EXPECT_EQ(said["unsupported"], 1);
    EXPECT_EQ(said["not_finite"], 1);
    EXPECT_EQ(said["moved"], 4998);
    const PointChunk after = read_all(file("smooth.ply"), 5000);
    EXPECT_EQ(after.position[10], (Vec3d{50, 60, 70}));
    EXPECT_EQ(after.normal[10], cloud.normals[10]);
    EXPECT_TRUE(std::isnan(after.position[20].x));
}

TEST_F(SmoothStage, AmountMostAndIterationsAreFollowed) {
    const std::string cloud = noisy("sphere", 0.003);
    const double whole = smooth(cloud)["rms_displacement"];
    SmoothConfig c;
    c.amount = 0.5;
    const auto half = smooth(cloud, c);
    EXPECT_NEAR(half["rms_displacement"].get<double>() / whole, 0.5, 1e-6);
    c.iterations = 2;
    EXPECT_NEAR(smooth(cloud, c)["rms_displacement"].get<double>() / whole, 0.75, 0.02);
    c = {};
    c.most = 0.002;
    const auto bounded = smooth(cloud, c);
    EXPECT_LE(bounded["max_displacement"].get<double>(), 0.002);
    const PointChunk before = read_all(cloud, 20000), after = read_all(file("smooth.ply"), 20000);
    for (std::size_t i = 0; i < after.size(); ++i)
        ASSERT_LT(length(after.position[i] - before.position[i]), 0.002 * (1 + 1e-9));
    c = {};
    c.amount = 0;
    smooth(cloud, c);
    const PointChunk kept = read_all(file("smooth.ply"), 20000);
    EXPECT_EQ(kept.position, before.position);
    EXPECT_NE(kept.normal, before.normal);
}

TEST_F(SmoothStage, PointsOutsideAllBallsGoToTheSurfaceBeneathThem) {
    // Noise of a third of a leaf's radius: its tails lie farther off than a surfel takes points
    // from.
    const std::string cloud = noisy("sphere", 0.01);
    const auto said = smooth(cloud);
    EXPECT_GE(said["moved"], 19995);
    std::size_t n_far = 0;
    const PointChunk before = read_all(cloud, 20000), after = read_all(file("smooth.ply"), 20000);
    for (std::size_t i = 0; i < after.size(); ++i) {
        const bool was_far = std::abs(length(before.position[i]) - 1) > 3 * 0.0346;
        n_far += was_far && std::abs(length(after.position[i]) - 1) > 0.02 ? 1 : 0;
    }
    EXPECT_LE(n_far, 3u);
    EXPECT_LT(rms_distance("sphere", after.position), 0.0346 / 8);
}

TEST_F(SmoothStage, ASparseShareOfTheModelsCloudIsPutOnTheModelAsItIs) {
    // A refit to a few points would be worse than the surfels that saw all.
    const std::string cloud = noisy("bumpy", 0.003);
    Cloud few = sampled("bumpy", 20000, 1, 0.003);
    few.positions.resize(400), few.normals.resize(400),
        few.scan_ids.resize(few.scan_ids.empty() ? 0 : 400);
    smooth(write(few, "few.ply"));
    const double share = rms_distance("bumpy", read_all(file("smooth.ply"), 400).position);

    const ModelFile model = ModelFile::open(file("m.slim"));
    const BallIndex index(model.tree());
    for (Vec3d& p : few.positions) p -= model.header().origin;
    std::vector<SmoothedPoint> alone(400);
    smooth_points({index}, {}, few.positions, few.normals, alone);
    std::vector<Vec3d> on_model;
    for (const SmoothedPoint& p : alone) on_model.push_back(p.position + model.header().origin);
    EXPECT_LE(share, 1.05 * rms_distance("bumpy", on_model));
}

TEST_F(SmoothStage, NormalsTurnedAroundThrowNoPointOntoAnotherSheet) {
    Cloud cloud = sampled("torus", 20000, 1, 3e-6);
    BuildConfig c = build_config(write(cloud, "c.ply"), "m.slim");
    c.t_mdl = 0.001;
    build(c);
    for (Vec3f& n : cloud.normals) n = {-n.x, -n.y, -n.z};
    const auto said = smooth(write(cloud, "turned.ply"));
    EXPECT_LT(said["max_displacement"], 1e-3);
    EXPECT_LT(rms_distance("torus", read_all(file("smooth.ply"), 20000).position), 1e-4);
}

TEST_F(SmoothStage, ThreadsDoNotChangeAByte) {
    const std::string cloud = noisy("bumpy", 0.003), m = mesh(0.02);
    std::string bytes[2][2];
    for (const int threads : {1, 4}) {
        const ThreadLimit limit(threads);
        for (const bool is_mesh : {false, true}) {
            std::filesystem::remove(file("smooth.ply.done.json"));
            smooth(is_mesh ? m : cloud);
            bytes[is_mesh][threads > 1] = read_bytes(file("smooth.ply"));
        }
    }
    EXPECT_EQ(bytes[0][0], bytes[0][1]);
    EXPECT_EQ(bytes[1][0], bytes[1][1]);
}

TEST_F(SmoothStage, GeoreferencedCoordinatesKeepTheirDigits) {
    Cloud cloud = sampled("sphere", 5000, 1, 0.003);
    for (Vec3d& p : cloud.positions) p += Vec3d{403000, 3604900, 1000};
    const std::string path = write(cloud, "geo.ply");
    build(build_config(path, "m.slim"));
    smooth(path);
    double sum = 0;
    for (const Vec3d& p : read_all(file("smooth.ply"), 5000).position)
        sum += std::pow(length(p - Vec3d{403000, 3604900, 1000}) - 1, 2);
    EXPECT_LT(std::sqrt(sum / 5000), 0.0104 / 3);
}

}  // namespace
}  // namespace slim::test
