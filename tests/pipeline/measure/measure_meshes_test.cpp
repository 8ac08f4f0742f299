#include "pipeline/measure/measure_meshes.h"

#include "pipeline/measure/measure_stage.h"
#include "tests/pipeline/build/fit_stages_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>

namespace slim::test {
namespace {

class MeasureMeshes : public FitStages {
protected:
    /// A square of two triangles, its last corner at `z`.
    std::string square(const std::string& name, const std::string& z,
                       const std::string& faces = "3 0 1 2\n3 0 2 3\n") {
        return folder_.write(
            name,
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double "
            "y\nproperty "
            "double z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
            "0 0 0\n3 0 0\n3 4 0\n0 4 " +
                z + "\n" + faces);
    }
    nlohmann::json measure(const std::string& original, const std::string& moved,
                           MeasureConfig c = {}) {
        c.model = original, c.cloud = moved;
        return run_as("measure", c, run_measure, listener_);
    }
};

TEST_F(MeasureMeshes, VertexByVertexAndFaceByFace) {
    const auto said = measure(square("a.ply", "0"), square("b.ply", "3"));
    EXPECT_EQ(said["vertices"], 4);
    EXPECT_EQ(said["faces"], 2);
    EXPECT_DOUBLE_EQ(said["diagonal"], 5);
    EXPECT_DOUBLE_EQ(said["max"], 0.6);
    EXPECT_DOUBLE_EQ(said["l2"], 0.3);
    EXPECT_EQ(said["p50"], 0);
    EXPECT_EQ(said["max_at"], (nlohmann::json{0.0, 4.0, 0.0}));
    // The second triangle's edge from (0, 0) to (3, 4) stays: its tip, 2.4 from there, is 3 above.
    const double turned = std::atan2(3, 2.4) * 180 / M_PI;
    EXPECT_NEAR(said["normal_mean_deg"].get<double>(), turned / 2, 1e-12);
    EXPECT_NEAR(said["normal_rms_deg"].get<double>(), turned / std::sqrt(2), 1e-12);
}

TEST_F(MeasureMeshes, FacesOfTheFirstCount) {
    const auto said = measure(square("a.ply", "0"), square("b.ply", "0", "3 2 3 0\n3 2 0 1\n"));
    EXPECT_EQ(said["l2"], 0);
    EXPECT_EQ(said["normal_mean_deg"], 0);
    const auto flat = measure(square("c.ply", "0", "3 0 1 2\n3 0 2 2\n"), square("d.ply", "1"));
    EXPECT_EQ(flat["faces_flat"], 1);
}

TEST_F(MeasureMeshes, WhatCannotBeComparedIsRefused) {
    const std::string a = square("a.ply", "0");
    EXPECT_EQ(code_of([&] { measure(a, folder_.write("p.xyz", "1 2 3\n4 5 6\n")); }),
              ExitCode::bad_data);
    EXPECT_NE(message_.find("4 vertices"), std::string::npos) << message_;
    EXPECT_NE(message_.find("slim build"), std::string::npos) << message_;
    EXPECT_EQ(code_of([&] { measure(a, square("nan.ply", "nan")); }), ExitCode::bad_data);
    EXPECT_NE(message_.find("vertex 3"), std::string::npos) << message_;
    const auto refused = [&](auto&& change, const std::string& key) {
        MeasureConfig c;
        change(c);
        EXPECT_EQ(code_of([&] { measure(a, a, c); }), ExitCode::usage) << key;
        EXPECT_NE(message_.find(key), std::string::npos) << message_;
    };
    refused([](MeasureConfig& c) { c.two_way = true; }, "two_way");
    refused([](MeasureConfig& c) { c.truth = "a.truth"; }, "truth");
    refused([](MeasureConfig& c) { c.samples = 10; }, "samples");
    refused([](MeasureConfig& c) { c.tolerance = 0.5; }, "tolerance");
    refused([](MeasureConfig& c) { c.threshold = 0.5; }, "threshold");
    refused([&](MeasureConfig& c) { c.output = file("x.png"); }, "x.png");
    MeasureConfig c;
    c.output = a;
    EXPECT_EQ(code_of([&] { measure(a, square("b.ply", "1"), c); }), ExitCode::usage);
}

TEST_F(MeasureMeshes, FiguresOfEveryVertexWithTheFaces) {
    const std::string a = square("a.ply", "0"), b = square("b.ply", "3");
    MeasureConfig c;
    c.per_point = file("p.ply");
    measure(a, b, c);
    const auto source = open_cloud(file("p.ply"));
    EXPECT_EQ(source->info().n_faces, 2u);
    EXPECT_EQ(read_all(file("p.ply"), 10).position[3], (Vec3d{0, 4, 3}));
    const std::string bytes = read_bytes(file("p.ply"));
    // double x y z, nx ny nz, scalars
    const std::size_t first = bytes.find("end_header\n") + 11, row = 3 * 8 + 3 * 4 + 3 * 4;
    ASSERT_EQ(bytes.size(), first + 4 * row + 2 * (1 + 3 * 4));
    const auto scalar = [&](std::size_t vertex, std::size_t k) {
        float value;
        std::memcpy(&value, bytes.data() + first + vertex * row + 36 + 4 * k, 4);
        return static_cast<double>(value);
    };
    const double turned = std::atan2(3, 2.4) * 180 / M_PI;
    for (std::size_t v = 0; v < 4; ++v) {
        EXPECT_EQ(scalar(v, 0), v == 3 ? 3 : 0) << v;
        EXPECT_EQ(scalar(v, 2), scalar(v, 0)) << v;
        // The second face turned; both have the same area, vertices 0 and 2 are of both.
        EXPECT_NEAR(scalar(v, 1), v == 1 ? 0 : v == 3 ? turned : turned / 2, 1e-4) << v;
    }
}

TEST_F(MeasureMeshes, AFileOfTheResultIsKept) {
    const std::string a = square("a.ply", "0"), b = square("b.ply", "3");
    MeasureConfig c;
    c.output = file("m.json");
    const auto once = measure(a, b, c);
    EXPECT_EQ(nlohmann::json::parse(read_bytes(file("m.json")))["l2"], once["l2"]);
    EXPECT_FALSE(once.contains("up_to_date"));
    EXPECT_EQ(measure(a, b, c)["up_to_date"], true);
    square("b.ply", "6");
    EXPECT_DOUBLE_EQ(measure(a, b, c)["max"], 1.2);
}

}  // namespace
}  // namespace slim::test
