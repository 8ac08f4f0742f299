#include "pipeline/measure/measure_stage.h"
#include "slim/base/parallel.h"
#include "tests/pipeline/build/fit_stages_support.h"
#include "tests/pipeline/measure/measure_ways_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>

// What measure does beside the errors of a cloud: the other way, per point, and shapes.

namespace slim::test {
namespace {

TEST_F(MeasureWays, SamplesOfASphereAddUpToItsAreaAndLieOnIt) {
    build_sphere();
    const json m = both_ways(model_, path_).at("model_to_cloud");
    EXPECT_EQ(m["to"], "points");
    EXPECT_NEAR(m["area"].get<double>(), 4 * std::numbers::pi, 0.06);
    EXPECT_GT(m["samples"], 15000);
    // 20,000 points on 4 pi: the nearest is half a mean spacing, 0.0125, off on average.
    const double l2 = m["l2"].get<double>() * std::sqrt(12.0);
    EXPECT_GT(l2, 0.010);
    EXPECT_LT(l2, 0.018);
}

TEST_F(MeasureWays, AModelWithoutItsCloudThereIsFoundTheOtherWayOnly) {
    build_sphere();
    Cloud half;
    for (std::size_t i = 0; i < cloud_.size(); ++i)
        if (cloud_.positions[i].z > 0) {
            half.positions.push_back(cloud_.positions[i]);
            half.normals.push_back(cloud_.normals[i]);
            half.truth.push_back(cloud_.truth[i]);
            half.scan_ids.push_back(0);
        }
    const json m = measured(model_, write(half, "half.ply"), [](MeasureConfig& c) {
        c.two_way = true, c.tolerance = 0.02;
    });
    EXPECT_DOUBLE_EQ(m["completeness"].get<double>(), 1);
    // and what is near the rim
    EXPECT_NEAR(m["model_to_cloud"]["within"].get<double>(), 0.53, 0.03);
    EXPECT_NEAR(m["model_to_cloud"]["max"].get<double>() * m["diagonal"].get<double>(),
                std::sqrt(2.0), 0.03);
    EXPECT_LT(m["model_to_cloud"]["max_at"][2].get<double>(), -0.98);
}

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

TEST_F(MeasureWays, AMeshInAnotherFrameIsRefusedAlsoBothWays) {
    build_sphere();
    const std::string away =
        folder_.write("away.ply",
                      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                      "property float y\nproperty float z\n"
                      "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
                      "9 0 0\n10 0 0\n9 1 0\n3 0 1 2\n");
    EXPECT_EQ(code_of([&] { both_ways(model_, away); }), ExitCode::numerical);
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

TEST_F(MeasureWays, ThreadsDoNotMatter) {
    build_sphere(5000);
    const auto at = [&](int threads) {
        const ThreadLimit limit(threads);
        return measured(model_, path_, [&](MeasureConfig& c) {
            c.two_way = true, c.samples = 5000, c.per_point = file("p.ply");
        });
    };
    const json one = at(1);
    const std::string bytes = read_bytes(file("p.ply"));
    EXPECT_EQ(at(7), one);
    EXPECT_EQ(read_bytes(file("p.ply")), bytes);
}

TEST_F(MeasureWays, EveryPointHasItsFiguresInItsPlace) {
    build_sphere();
    Cloud one_off = cloud_;
    one_off.positions[7] *= 1.02;                 // outside
    one_off.positions[8] *= 0.99;                 // inside
    one_off.positions[9] += Vec3d{50, 0, 0};      // missed
    one_off.positions[10].x = std::nan("");
    measured(model_, write(one_off, "one_off.ply"),
             [&](MeasureConfig& c) { c.per_point = file("points.ply"); });
    const std::string bytes = read_bytes(file("points.ply"));
    for (const char* name : {"scalar_distance", "scalar_normal_angle", "scalar_k1_error",
                             "scalar_k2_error", "scalar_mean_curvature_error", "quality"})
        EXPECT_NE(bytes.find(std::string("property float ") + name + "\n"), std::string::npos)
            << name;
    EXPECT_NE(bytes.find("element vertex 20000\n"), std::string::npos);
    // double x y z, float nx ny nz, ushort scan, six floats
    constexpr std::size_t kRow = 24 + 12 + 2 + 24;
    const char* rows = bytes.data() + bytes.find("end_header\n") + 11;
    ASSERT_EQ(bytes.size() - bytes.find("end_header\n") - 11, 20000 * kRow);
    const auto scalar = [&](std::size_t point, std::size_t k) {
        float value;
        std::memcpy(&value, rows + point * kRow + 38 + 4 * k, 4);
        return value;
    };
    EXPECT_NEAR(scalar(7, 0), 0.02, 2e-4);
    EXPECT_NEAR(scalar(8, 0), -0.01, 2e-4);
    EXPECT_EQ(scalar(7, 5), scalar(7, 0));
    EXPECT_TRUE(std::isnan(scalar(9, 0)) && std::isnan(scalar(9, 5)));
    EXPECT_TRUE(std::isnan(scalar(10, 0)));
    EXPECT_LT(std::abs(scalar(11, 0)), 1e-4);
}

TEST_F(MeasureWays, PercentilesAndCompletenessAreThoseOfTheDistances) {
    build_sphere();
    Cloud off = cloud_;  // a tenth is 1 % of L off
    const double step = 0.01 * std::sqrt(12.0);
    for (std::size_t i = 0; i < off.size(); i += 10) off.positions[i] *= 1 + step;
    const json m =
        measured(model_, write(off, "off.ply"), [](MeasureConfig& c) { c.tolerance = 0.005; });
    EXPECT_DOUBLE_EQ(m["completeness"].get<double>(), 0.9);
    EXPECT_NEAR(m["p95"].get<double>(), 0.01, 1e-4);
    EXPECT_LT(m["p90"].get<double>(), 1e-4);
    EXPECT_LT(m["p50"].get<double>(), m["p90"].get<double>());
}

TEST_F(MeasureWays, AShapeMeasuresACloudExactly) {
    Cloud off = sampled("torus", 2000);
    for (std::size_t i = 0; i < off.size(); ++i) off.positions[i] += off.truth[i].normal * 0.01;
    const std::string path = write(off, "off.ply");
    const json m = measured("shape:torus", path, [](MeasureConfig&) {});
    EXPECT_NEAR(m["l2"].get<double>() * m["diagonal"].get<double>(), 0.01, 1e-9);
    EXPECT_LT(m["normal_rms_deg"].get<double>(), 1e-4);
    EXPECT_LT(m["k1_rms"].get<double>(), 1e-6);
    EXPECT_EQ(code_of([&] { measured("shape:tours", path, [](MeasureConfig&) {}); }),
              ExitCode::usage);
}

TEST_F(MeasureWays, AMissingTruthIsNamed) {
    build_sphere(2000);
    EXPECT_EQ(code_of([&] {
                  measured(model_, path_, [](MeasureConfig& c) { c.truth = "nowhere.truth"; });
              }),
              ExitCode::bad_data);
    EXPECT_NE(message_.find("nowhere.truth: the truth cannot be read"), std::string::npos)
        << message_;
    EXPECT_NE(message_.find("expected"), std::string::npos);
}

TEST_F(MeasureWays, TruthGoesWithItsPointsThroughAllChunks) {
    Cloud part = sampled("torus", 3001), many;  // no divisor of a chunk's length
    for (int k = 0; k < 90; ++k) {
        many.positions.insert(many.positions.end(), part.positions.begin(), part.positions.end());
        many.normals.insert(many.normals.end(), part.normals.begin(), part.normals.end());
        many.truth.insert(many.truth.end(), part.truth.begin(), part.truth.end());
        many.scan_ids.insert(many.scan_ids.end(), part.scan_ids.begin(), part.scan_ids.end());
    }
    const json m = measured("shape:torus", write(many, "many.ply"), [](MeasureConfig&) {});
    EXPECT_EQ(m["points"], 90 * 3001);
    EXPECT_LT(m["k1_rms"].get<double>(), 1e-6);
    EXPECT_LT(m["normal_rms_deg"].get<double>(), 1e-4);
}

TEST_F(MeasureWays, PointsThatNoShapeIsNearestToAreCountedAndSaid) {
    const std::string few = folder_.write("few.xyz", "0 0 0\n3 4 0\n1e35 0 0\n");
    const json m = measured("shape:sphere", few, [](MeasureConfig&) {});
    EXPECT_EQ(m["points"], 3);
    EXPECT_EQ(m["missed"], 1);
    EXPECT_NEAR(m["max"].get<double>() * m["diagonal"].get<double>(), 4, 1e-6);
    EXPECT_NEAR(m["l2"].get<double>() * m["diagonal"].get<double>(), std::sqrt(17.0 / 2), 1e-6);
    ASSERT_EQ(listener_.warnings.size(), 1u);
    EXPECT_NE(listener_.warnings[0].find("1 of its 3 points not measured"), std::string::npos)
        << listener_.warnings[0];
    const std::string path = folder_.write("far.xyz", "1e35 0 0\n");
    EXPECT_EQ(code_of([&] { measured("shape:sphere", path, [](MeasureConfig&) {}); }),
              ExitCode::numerical);
}

}  // namespace
}  // namespace slim::test
