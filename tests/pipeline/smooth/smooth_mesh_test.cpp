#include "tests/pipeline/smooth/smooth_stage_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <string>

namespace slim::test {
namespace {

TEST_F(SmoothStage, AMeshComesNearerToItsShapeAndKeepsFacesAndAttributes) {
    const std::string in = mesh(0.02);
    build(build_config(in, "m.slim"));
    const auto said = smooth(in);
    EXPECT_EQ(said["mode"], "mesh");
    EXPECT_EQ(said["points"], 41 * 80);
    EXPECT_EQ(said["faces"], 40 * 80);
    EXPECT_EQ(said["held"], 160);  // around the open poles
    EXPECT_LT(rms_distance("sphere", read_all(file("smooth.ply"), 5000).position),
              rms_distance("sphere", read_all(in, 5000).position) / 2);
    const std::string before = read_bytes(in), after = read_bytes(file("smooth.ply"));
    const auto faces = before.find("\n4 ");
    EXPECT_TRUE(after.ends_with(before.substr(faces)));
}

TEST_F(SmoothStage, TheBoundaryOfAMeshStays) {
    const std::string in = mesh(0.02, true);
    build(build_config(in, "m.slim"));
    smooth(in);
    const PointChunk before = read_all(in, 5000), after = read_all(file("smooth.ply"), 5000);
    std::size_t n_moved = 0;
    for (std::size_t i = 0; i < before.size(); ++i) {
        const bool on_rim = i < 80 || i >= before.size() - 80;
        if (on_rim) {
            EXPECT_EQ(after.position[i], before.position[i]);
        }
        n_moved += after.position[i] == before.position[i] ? 0 : 1;
    }
    EXPECT_EQ(n_moved, before.size() - 160);
}

TEST_F(SmoothStage, VerticesThatStaySoThatNoFaceTurnsOverHaveNotMoved) {
    const std::string in = mesh(0.15);
    build(build_config(in, "m.slim"));
    const auto said = smooth(in);
    const std::size_t kept = said["vertices_kept"], held = said["held"];
    EXPECT_GT(kept, 0u);
    EXPECT_LT(kept, said["vertices_held_back"]);
    EXPECT_EQ(said["unsupported"], 0);
    EXPECT_EQ(said["moved"].get<std::size_t>() + kept + held, said["points"]);
    const PointChunk before = read_all(in, 5000), after = read_all(file("smooth.ply"), 5000);
    std::size_t n_stay = 0;
    for (std::size_t i = 0; i < before.size(); ++i)
        n_stay += after.position[i] == before.position[i] ? 1 : 0;
    EXPECT_EQ(n_stay, kept + held);
}

TEST_F(SmoothStage, AdvisesSharpLeavesWhereAMeshHasEdgesThatTheModelRoundsOff) {
    const std::string sphere = mesh(0.02);
    build(build_config(sphere, "m.slim"));
    listener_.infos.clear();
    EXPECT_LT(smooth(sphere)["at_edges"], 0.03);
    EXPECT_TRUE(listener_.infos.empty()) << listener_.infos[0];
    for (const double noise : {0.0, 0.01}) {
        const std::string in = cube(noise);
        BuildConfig b = build_config(in, "m.slim");
        b.sharp = "off";
        build(b);
        listener_.infos.clear();
        EXPECT_GT(smooth(in)["at_edges"], 0.1);
        ASSERT_EQ(listener_.infos.size(), 1u);
        EXPECT_NE(listener_.infos[0].find("built with --sharp on"), std::string::npos)
            << listener_.infos[0];
        b.sharp = "on";
        build(b);
        listener_.infos.clear();
        EXPECT_FALSE(smooth(in).contains("at_edges"));
        EXPECT_TRUE(listener_.infos.empty()) << listener_.infos[0];
    }
}

TEST_F(SmoothStage, EdgesAreSoughtByTheDegreeOfTheModel) {
    const std::string in = cube(0);
    std::map<std::string, double> share;
    for (const char* degree : {"2", "3", "auto"}) {
        BuildConfig b = build_config(in, "m.slim");
        b.sharp = "off";
        b.degree = degree;
        build(b);
        share[degree] = smooth(in)["at_edges"];
    }
    EXPECT_GT(std::abs(share["3"] - share["2"]), 0.05);  // so that it would tell
    EXPECT_NE(share["auto"], share["3"]);
}

TEST_F(SmoothStage, AMeshIsSmoothedAsPointsIfAsked) {
    const std::string in = mesh(0.02);
    build(build_config(in, "m.slim"));
    SmoothConfig c;
    c.mode = "points";
    const auto said = smooth(in, c);
    EXPECT_EQ(said["mode"], "points");
    EXPECT_EQ(said["moved"], 41 * 80);
    c.mode = "mesh";
    c.output = file("smooth.xyz");
    EXPECT_EQ(code_of([&] { smooth(folder_.write("p.xyz", "1 2 3\n"), c); }), ExitCode::bad_data);
}

TEST_F(SmoothStage, AMeshOfHeldAndUnusedVerticesIsNoneInAnotherFrame) {
    build(build_config(write(sampled("sphere", 3000), "c.ply"), "m.slim"));
    const std::string lone =
        folder_.write("lone.ply",
                      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float "
                      "y\nproperty float z\n"
                      "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
                      "0 0 1\n0.1 0 0.995\n0 0.1 0.995\n9 9 9\n3 0 1 2\n");
    const auto said = smooth(lone);
    EXPECT_EQ(said["faces_unsupported"], 0);
    EXPECT_EQ(said["held"], 3);
}

TEST_F(SmoothStage, AMeshInAnotherUnitIsRefused) {
    Cloud cloud = sampled("sphere", 3000);
    for (Vec3d& p : cloud.positions) p *= 0.001;
    build(build_config(write(cloud, "c.ply"), "m.slim"));
    for (const bool open : {false, true}) {
        const std::string millimetres = mesh(0, open);
        EXPECT_EQ(code_of([&] { smooth(millimetres); }), ExitCode::numerical);
        EXPECT_NE(message_.find("same unit?"), std::string::npos) << message_;
        EXPECT_FALSE(std::filesystem::exists(file("smooth.ply")));
    }
}

}  // namespace
}  // namespace slim::test
