#include "pipeline/measure/measure_stage.h"
#include "slim/base/parallel.h"
#include "tests/pipeline/build/fit_stages_support.h"
#include "tests/pipeline/measure/measure_ways_support.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

// What measure says of a mesh's faces.

namespace slim::test {
namespace {

TEST_F(MeasureWays, FacesAreMeasuredExactly) {
    build_sphere();
    // A cube about the sphere: the sphere's farthest points are at (1, 1, 1) / sqrt(3).
    const std::string cube =
        folder_.write("cube.ply",
                      "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\n"
                      "property float y\nproperty float z\n"
                      "element face 6\nproperty list uchar int vertex_indices\nend_header\n"
                      "-1 -1 -1\n1 -1 -1\n1 1 -1\n-1 1 -1\n-1 -1 1\n1 -1 1\n1 1 1\n-1 1 1\n"
                      "4 0 3 2 1\n4 4 5 6 7\n4 0 1 5 4\n4 2 3 7 6\n4 1 2 6 5\n4 0 4 7 3\n");
    const json m = both_ways(model_, cube).at("model_to_cloud");
    EXPECT_EQ(m["to"], "faces");
    EXPECT_NEAR(m["max"].get<double>() * std::sqrt(12.0), 1 - 1 / std::sqrt(3.0),
                0.006);  // samples are 0.025 apart
}

/// A box 4 x 2 x 1 of quadrangles, in text; its last face, above, only if asked for.
std::string box(bool is_closed, bool inwards = false) {
    std::string text =
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
        "property float z\nelement face " +
        std::string(is_closed ? "6" : "5") +
        "\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n4 0 0\n4 2 0\n0 2 0\n0 0 1\n4 0 1\n4 2 1\n0 2 1\n";
    const std::string out =
        "4 0 3 2 1\n4 0 1 5 4\n4 2 3 7 6\n4 1 2 6 5\n4 0 4 7 3\n" +
        std::string(is_closed ? "4 4 5 6 7\n" : "");
    const std::string in =
        "4 1 2 3 0\n4 4 5 1 0\n4 6 7 3 2\n4 5 6 2 1\n4 3 7 4 0\n" +
        std::string(is_closed ? "4 7 6 5 4\n" : "");
    return text + (inwards ? in : out);
}

TEST_F(MeasureWays, AFaceThatTheModelLacksIsSeen) {
    const std::string open = folder_.write("open.ply", box(false)),
                      closed = folder_.write("closed.ply", box(true)),
                      inwards = folder_.write("inwards.ply", box(true, true));
    auto config = build_config(open, "open.slim");
    config.sharp = "on";
    build(config);
    for (const std::string& mesh : {open, closed, inwards}) {
        SCOPED_TRACE(mesh);
        const json m = measured(file("open.slim"), mesh, [](MeasureConfig&) {});
        const double area = mesh == open ? 20 : 28;
        EXPECT_EQ(m["points"], 8);
        EXPECT_LT(m["max"].get<double>(), 0.01);  // the vertices are all there
        EXPECT_NEAR(m["faces"]["area"].get<double>(), area, 1e-9);
        EXPECT_EQ(m["faces"]["samples"], 200000);
        EXPECT_NEAR(m["completeness"].get<double>(), 20 / area, 0.004);
        EXPECT_EQ(m["completeness"], m["faces"]["completeness"]);
        EXPECT_LT(m["faces"]["opposed"], 100);
        if (mesh == open) {
            EXPECT_LT(m["faces"]["l2"].get<double>(), 1e-3);
            // Of the vertices, whose normals are means, it is 50 degrees.
            EXPECT_LT(m["faces"]["normal_rms_deg"].get<double>(), 2);
        }
    }
}

/// Its own normals make a cloud of it whose faces nobody reads to build it.
TEST_F(MeasureWays, AMeshWithABadFaceIsMeasuredByItsVertices) {
    std::string text = box(true);
    build(build_config(folder_.write("box.ply", text), "box.slim"));
    text.replace(text.find("4 4 5 6 7"), 9, "4 4 5 6 99");
    text.replace(text.find("element face"), 0,
                 "property float nx\nproperty float ny\nproperty float nz\n");
    for (const char* vertex : {"0 0 0", "4 0 0", "4 2 0", "0 2 0"})
        text.replace(text.find(std::string(vertex) + "\n") + 5, 0, " 0 0 -1");
    for (const char* vertex : {"0 0 1", "4 0 1", "4 2 1", "0 2 1"})
        text.replace(text.find(std::string(vertex) + "\n") + 5, 0, " 0 0 1");
    const json m =
        measured(file("box.slim"), folder_.write("bad.ply", text), [](MeasureConfig&) {});
    EXPECT_EQ(m["points"], 8);
    EXPECT_FALSE(m.contains("faces"));
}

/// A side is that of the normals: faces that are wound the other way are as good.
TEST_F(MeasureWays, FacesAreOpposedByTheirOwnNormalsNotByTheirWinding) {
    build_sphere(2000);
    constexpr int kRings = 24, kAround = 48;  // vertices of a ball
    const auto opposed = [&](int way_of_normals, bool outwards) {
        std::string text = fmt::format(
            "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
            "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
            "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
            (kRings + 1) * kAround, kRings * kAround);
        for (int i = 0; i <= kRings; ++i)
            for (int j = 0; j < kAround; ++j) {
                const double down = std::numbers::pi * i / kRings,
                             round = 2 * std::numbers::pi * j / kAround;
                const double x = std::sin(down) * std::cos(round),
                             y = std::sin(down) * std::sin(round), z = std::cos(down);
                text += fmt::format("{} {} {} {} {} {}\n", x, y, z, way_of_normals * x,
                                    way_of_normals * y, way_of_normals * z);
            }
        for (int i = 0; i < kRings; ++i)
            for (int j = 0; j < kAround; ++j) {
                const int a = i * kAround + j, b = i * kAround + (j + 1) % kAround;
                text += outwards ? fmt::format("4 {} {} {} {}\n", a, a + kAround, b + kAround, b)
                                 : fmt::format("4 {} {} {} {}\n", a, b, b + kAround, a + kAround);
            }
        return measured(model_, folder_.write("mesh.ply", text), [](MeasureConfig&) {})
            .at("faces");
    };
    const json right = opposed(1, true);
    EXPECT_EQ(right["missed"], 0);
    EXPECT_EQ(right["opposed"], 0);
    EXPECT_EQ(opposed(1, false)["opposed"], 0);
    // Normals that face inwards say so, whichever way the faces are wound.
    for (const bool outwards : {true, false})
        EXPECT_EQ(opposed(-1, outwards)["opposed"], 200000) << outwards;
}

TEST_F(MeasureWays, SamplesOfFacesAreTheSameForAnyThreads) {
    const std::string mesh = folder_.write("box.ply", box(true));
    build(build_config(mesh, "box.slim"));
    const json one = [&] {
        const ThreadLimit limit(1);
        return measured(file("box.slim"), mesh, [](MeasureConfig&) {});
    }();
    const json all = measured(file("box.slim"), mesh, [](MeasureConfig&) {});
    EXPECT_EQ(one["faces"], all["faces"]);
}

TEST_F(MeasureWays, DegenerateFacesAreMeasuredAsWhatIsLeftOfThemAndNoneIsRefused) {
    build_sphere(2000);
    const auto mesh = [&](const std::string& faces) {
        return folder_.write("mesh.ply",
                             "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                             "property float y\nproperty float z\n"
                             "element face 1\nproperty list uchar int vertex_indices\n"
                             "end_header\n1 0 0\n0 1 0\n0 0 1\n" +
                                 faces);
    };
    const json point = both_ways(model_, mesh("3 2 2 2\n")).at("model_to_cloud");
    EXPECT_NEAR(point["max"].get<double>() * std::sqrt(12.0), 2, 0.01);
    EXPECT_EQ(code_of([&] { both_ways(model_, mesh("2 0 1\n")); }), ExitCode::bad_data);
    EXPECT_NE(message_.find("mesh.ply: two_way: no face"), std::string::npos) << message_;
}

TEST_F(MeasureWays, AFaceTooFarForSquaresIsRefused) {
    // Its distance was null in the result.
    build_sphere(2000);
    const std::string far =
        folder_.write("far.ply",
                      "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\n"
                      "property double y\nproperty double z\n"
                      "element face 1\nproperty list uchar int vertex_indices\nend_header\n1 0 0\n"
                      "1e300 0 0\n-1e300 0 1\n0 1e300 0\n3 1 2 3\n");
    EXPECT_EQ(code_of([&] { both_ways(model_, far); }), ExitCode::bad_data);
    EXPECT_NE(message_.find("far.ply: two_way"), std::string::npos) << message_;
}

}  // namespace
}  // namespace slim::test
