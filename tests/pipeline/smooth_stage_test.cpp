#include "pipeline/smooth_stage.h"

#include "formats/model_file.h"
#include "slim/base/hash.h"
#include "slim/base/parallel.h"
#include "slim/shapes/foot_point.h"
#include "slim/smooth/smoothing.h"
#include "tests/pipeline/fit_stages_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace slim::test {
namespace {

double rms_distance(const char* shape, const std::vector<Vec3d>& points) {
    double sum = 0;
    for (const Vec3d& p : points) sum += std::pow(signed_distance(find_shape(shape), p), 2);
    return std::sqrt(sum / static_cast<double>(points.size()));
}

class SmoothStage : public FitStages {
protected:
    nlohmann::json smooth(const std::string& cloud, SmoothConfig c = {}) {
        c.model = file("m.slim");
        c.cloud = cloud;
        if (c.output.empty()) c.output = file("smooth.ply");
        return run_as("smooth", c, run_smooth, listener_);
    }
    std::string noisy(const char* shape, double noise, bool normals = true) {
        const std::string cloud = write(sampled(shape, 20000, 1, noise), "noisy.ply", normals);
        build(build_config(cloud, "m.slim"));
        return cloud;
    }
    /// A sphere of n by 2 n quadrangles around a pole, noisy; open: without its lower half.
    std::string mesh(double noise, bool open = false) {
        const int n = 40, rows = open ? n / 2 : n;
        std::string vertices, faces;
        int n_vertices = 0, n_faces = 0;
        for (int i = 0; i <= rows; ++i)
            for (int k = 0; k < 2 * n; ++k, ++n_vertices) {
                const double a = (0.5 + i) * M_PI / (n + 1), b = k * M_PI / n;
                const auto key = static_cast<std::uint64_t>(n_vertices);
                const double r = 1 + noise * 2 * (unit_interval(keyed_hash(1, key)) - 0.5);
                for (const double x :
                     {std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)})
                    vertices += std::to_string(r * x) + " ";
                vertices += std::to_string(n_vertices % 7) + "\n";
            }
        for (int i = 0; i < rows; ++i)
            for (int k = 0; k < 2 * n; ++k, ++n_faces) {
                const int l = (k + 1) % (2 * n), a = 2 * n * i, b = a + 2 * n;
                faces += "4";
                for (const int v : {a + k, b + k, b + l, a + l}) faces += " " + std::to_string(v);
                faces += "\n";
            }
        return folder_.write(
            "mesh.ply", "ply\nformat ascii 1.0\nelement vertex " + std::to_string(n_vertices) +
                            "\nproperty double x\nproperty double y\nproperty double z\nproperty "
                            "uchar tag\nelement face " +
                            std::to_string(n_faces) +
                            "\nproperty list uchar int vertex_indices\nend_header\n" + vertices +
                            faces);
    }
};

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
    EXPECT_NE(listener_.infos[0].find("by a noise of"), std::string::npos) << listener_.infos[0];
    EXPECT_LT(said["noise"], 1e-4);
    EXPECT_EQ(said["leaves_noise_unknown"], 0);
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

TEST_F(SmoothStage, ACleanCloudIsNotMadeWorse) {
    // Noise far below what the model's leaves are off by: its points go only as far as their noise
    // allows.
    for (const char* shape : {"torus", "bumpy"})
        for (const double noise : {0.0, 1e-6, 1e-5}) {
            SCOPED_TRACE(shape + std::to_string(noise));
            const std::string cloud = write(sampled(shape, 50000, 1, noise), "c.ply");
            build(build_config(cloud, "m.slim"));
            const auto said = smooth(cloud);
            const double before = rms_distance(shape, read_all(cloud, 50000).position);
            const double after = rms_distance(shape, read_all(file("smooth.ply"), 50000).position);
            EXPECT_LT(after, 1.05 * before + 2e-7);
            if (noise < 1e-5) {
                EXPECT_GT(said["points_held_back"], 40000);
            }
        }
}

// A cloud of two scanners: the noisy half is no misfit of the surface's, the quiet one says nothing
// about it.
TEST_F(SmoothStage, NoiseThatVariesOverTheCloudIsTakenOffEverywhere) {
    Cloud cloud = sampled("sphere", 40000);
    const auto upper = [](const Vec3d& p) { return p.z > 0; };
    for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
        const double u = 1 - unit_interval(keyed_hash(3, i, 1)),
                     v = unit_interval(keyed_hash(3, i, 2));
        const double noise = upper(cloud.positions[i]) ? 0.01 : 0.001;
        cloud.positions[i] += to_double(cloud.normals[i]) *
                              (noise * std::sqrt(-2 * std::log(u)) * std::cos(2 * M_PI * v));
    }
    const std::string path = write(cloud, "c.ply");
    build(build_config(path, "m.slim"));
    smooth(path);
    std::vector<Vec3d> above, below;
    for (const Vec3d& p : read_all(file("smooth.ply"), 40000).position)
        (upper(p) ? above : below).push_back(p);
    EXPECT_LT(rms_distance("sphere", above), 0.0025);
    EXPECT_LT(rms_distance("sphere", below), 0.0005);
}

// Planes through the nearest of a terrace's points leave nothing of the rounding.
TEST_F(SmoothStage, HeightsInCoarseStepsAreSmoothed) {
    constexpr double kStep = 0.01;
    const auto height = [](double u, double v) { return 0.1 * std::sin(3 * u) * std::cos(2 * v); };
    Cloud cloud;
    for (std::uint64_t i = 0; i < 30000; ++i) {
        const double u = 2 * unit_interval(keyed_hash(3, i, 1)) - 1,
                     v = 2 * unit_interval(keyed_hash(3, i, 2)) - 1;
        cloud.positions.push_back({u, v, std::round(height(u, v) / kStep) * kStep});
        cloud.normals.push_back(
            to_float(normalized(Vec3d{-0.3 * std::cos(3 * u) * std::cos(2 * v),
                                      0.2 * std::sin(3 * u) * std::sin(2 * v), 1})));
        cloud.scan_ids.push_back(0);
    }
    const std::string path = write(cloud, "c.ply");
    build(build_config(path, "m.slim"));
    smooth(path);
    double sum = 0;
    for (const Vec3d& p : read_all(file("smooth.ply"), 30000).position)
        sum += std::pow(p.z - height(p.x, p.y), 2);
    EXPECT_LT(std::sqrt(sum / 30000), 0.25 * kStep / std::sqrt(12.0));
}

// So few leaves that all are about each: the noisy half's are not held to what the quiet half has.
TEST_F(SmoothStage, TwoNoisesOnASmallCloudAreTakenOff) {
    Cloud cloud = sampled("sphere", 5000);
    std::vector<Vec3d> above, before;
    for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
        const double u = 1 - unit_interval(keyed_hash(3, i, 1)),
                     v = unit_interval(keyed_hash(3, i, 2));
        const bool upper = cloud.positions[i].z > 0;
        cloud.positions[i] +=
            to_double(cloud.normals[i]) *
            ((upper ? 0.01 : 0.001) * std::sqrt(-2 * std::log(u)) * std::cos(2 * M_PI * v));
        if (upper) before.push_back(cloud.positions[i]);
    }
    const std::string path = write(cloud, "c.ply");
    build(build_config(path, "m.slim"));
    smooth(path);
    for (const Vec3d& p : read_all(file("smooth.ply"), 5000).position)
        if (p.z > 0) above.push_back(p);
    EXPECT_LT(rms_distance("sphere", above), 0.5 * rms_distance("sphere", before));
}

// At the poles the six nearest lie on one line.
TEST_F(SmoothStage, ScanLinesThatCloseAtPolesAreSmoothedThere) {
    constexpr int kLines = 61;
    Cloud cloud;
    for (std::uint64_t i = 0; i < 30000; ++i) {
        const double z =
            static_cast<double>(static_cast<int>(i % kLines) - kLines / 2) / (kLines / 2 + 1);
        const double t = 2 * M_PI * unit_interval(keyed_hash(3, i, 1)), w = std::sqrt(1 - z * z);
        const double a = 1 - unit_interval(keyed_hash(3, i, 2)),
                     b = unit_interval(keyed_hash(3, i, 3));
        const Vec3d n{w * std::cos(t), w * std::sin(t), z};
        cloud.positions.push_back(
            n * (1 + 0.003 * std::sqrt(-2 * std::log(a)) * std::cos(2 * M_PI * b)));
        cloud.normals.push_back(to_float(n)), cloud.scan_ids.push_back(0);
    }
    const std::string path = write(cloud, "c.ply");
    build(build_config(path, "m.slim"));
    smooth(path);
    std::vector<Vec3d> poles;
    for (const Vec3d& p : read_all(file("smooth.ply"), 30000).position)
        if (std::abs(p.z) > 0.9) poles.push_back(p);
    ASSERT_GT(poles.size(), 1000u);
    EXPECT_LT(rms_distance("sphere", poles), 0.0006);
}

// Copies lie on the plane through each other.
TEST_F(SmoothStage, PointsThatStandThereTwiceAreAsNoisyAsOnce) {
    Cloud cloud = sampled("sphere", 10000, 1, 0.003);
    const auto twice = [](auto& values) {
        const auto once = values;
        values.insert(values.end(), once.begin(), once.end());
    };
    twice(cloud.positions), twice(cloud.normals), twice(cloud.scan_ids);
    const std::string path = write(cloud, "c.ply");
    build(build_config(path, "m.slim"));
    smooth(path);
    EXPECT_LT(rms_distance("sphere", read_all(file("smooth.ply"), 20000).position),
              0.3 * rms_distance("sphere", cloud.positions));
}

// Most of its leaves hold an edge. Measured (uniform cloud, noise along rays): 0.82 and 0.69 of the
// cloud's own error.
TEST_F(SmoothStage, ANoisyCloudOfManyEdgesIsMadeBetter) {
    for (const auto& [noise, most] : {std::pair(1e-4, 0.95), std::pair(3e-4, 0.85)}) {
        SCOPED_TRACE(noise);
        const std::string cloud = write(sampled("sculpture", 50000, 1, noise), "c.ply");
        build(build_config(cloud, "m.slim"));
        smooth(cloud);
        EXPECT_LT(rms_distance("sculpture", read_all(file("smooth.ply"), 50000).position),
                  most * rms_distance("sculpture", read_all(cloud, 50000).position));
    }
}

TEST_F(SmoothStage, PointsThatAreHeldBackGoNoFartherInMoreIterations) {
    const std::string cloud = write(sampled("torus", 50000, 1, 3e-6), "c.ply");
    build(build_config(cloud, "m.slim"));
    SmoothConfig c;
    EXPECT_GT(smooth(cloud, c)["points_held_back"], 25000);
    const double once = rms_distance("torus", read_all(file("smooth.ply"), 50000).position);
    c.iterations = 10;
    smooth(cloud, c);
    EXPECT_NEAR(rms_distance("torus", read_all(file("smooth.ply"), 50000).position) / once, 1,
                0.02);
}

// Beside edges the surface's normals are off by more than 45 degrees.
TEST_F(SmoothStage, NormalsOfPointsThatAreHeldBackStay) {
    const Cloud exact = sampled("sculpture", 50000);
    const std::string cloud = write(exact, "c.ply");
    build(build_config(cloud, "m.slim"));
    EXPECT_GT(smooth(cloud)["points_held_back"], 40000);
    const auto normals = read_all(file("smooth.ply"), 50000).normal;
    double sum = 0;
    for (std::size_t i = 0; i < normals.size(); ++i)
        sum += sq_length(to_double(normals[i]) - to_double(exact.normals[i]));
    EXPECT_LT(std::sqrt(sum / 50000),
              0.04);  // 1.2 degrees; replaced where they differ by more than 45: 5
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
    const std::string cloud = write(sampled("bumpy", 120000, 1, 1e-6), "c.ply");
    BuildConfig b = build_config(cloud, "m.slim");
    b.t_mdl = 1e-4;
    const auto built = build(b);
    ASSERT_GT(built["leaves"], 10000);
    listener_.warnings.clear();
    SmoothConfig c;
    c.memory = "64MiB";
    const auto said = smooth(cloud, c);
    EXPECT_EQ(said["leaves_refitted"], 0);
    EXPECT_EQ(said["leaves_kept_for_memory"], built["leaves"]);
    EXPECT_EQ(said["moved"], 120000);
    ASSERT_GE(listener_.warnings.size(), 1u);
    EXPECT_NE(listener_.warnings[0].find("--memory"), std::string::npos);
    EXPECT_GT(said["points_held_back"], 0);  // none without shares
    EXPECT_LT(rms_distance("bumpy", read_all(file("smooth.ply"), 120000).position),
              1.05 * rms_distance("bumpy", read_all(cloud, 120000).position));
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
