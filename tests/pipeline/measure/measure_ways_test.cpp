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

TEST_F(MeasureWays, AShapeIsMeasuredWhereItsOffsetSays) {
    const std::vector<double> offset{500000, 4e6, 100};
    Cloud off = sampled("torus", 2000);
    for (std::size_t i = 0; i < off.size(); ++i)
        off.positions[i] += off.truth[i].normal * 0.01 + Vec3d{offset[0], offset[1], offset[2]};
    const std::string path = write(off, "far.ply");
    const json m = measured("shape:torus", path, [&](MeasureConfig& c) { c.offset = offset; });
    EXPECT_EQ(m["missed"], 0);
    EXPECT_NEAR(m["l2"].get<double>() * m["diagonal"].get<double>(), 0.01, 1e-8);
    EXPECT_EQ(code_of([&] { measured("shape:torus", path, [](MeasureConfig&) {}); }),
              ExitCode::numerical);
    EXPECT_NE(message_.find("--offset"), std::string::npos) << message_;
    EXPECT_EQ(code_of([&] {
                  measured("shape:torus", path, [](MeasureConfig& c) { c.offset = {1, 2}; });
              }),
              ExitCode::usage);
    build_sphere(2000);
    EXPECT_EQ(
        code_of([&] { measured(model_, path_, [&](MeasureConfig& c) { c.offset = offset; }); }),
        ExitCode::usage);
    EXPECT_NE(message_.find("offset"), std::string::npos) << message_;
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
