#include "pipeline/measure/measure_stage.h"

#include "slim/base/frame.h"
#include "tests/pipeline/build/fit_stages_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace slim::test {
namespace {

class MeasureStage : public FitStages {
protected:
    MeasureStage() : cloud_(sampled("sphere", 20000)) {
        path_ = write(cloud_, "sphere.ply");
        build(build_config(path_, "m.slim"));
    }
    Cloud cloud_;
    std::string path_;
};

TEST_F(MeasureStage, ErrorsOnASphereAreThoseOfTheFit) {
    const auto m = measure(file("m.slim"), path_);
    EXPECT_EQ(m["points"], 20000);
    EXPECT_EQ(m["missed"], 0);
    EXPECT_EQ(m["opposed"], 0);
    EXPECT_EQ(m["without_normal"], 0);
    EXPECT_EQ(m["bytes"], std::filesystem::file_size(file("m.slim")));
    const double diagonal = m["diagonal"];
    EXPECT_NEAR(diagonal, std::sqrt(12.0), 0.01);
    // Quadrics of radius 0.2 leave fourth-order terms of the sphere. Measured: l2 3.0e-6, max
    // 1.4e-5, 0.018 degrees, curvatures 0.006 to 0.010.
    EXPECT_LT(m["l2"].get<double>(), 6e-6);
    EXPECT_LT(m["max"].get<double>(), 5e-5);
    EXPECT_LT(m["normal_rms_deg"].get<double>(), 0.04);
    for (const char* key : {"k1_rms", "k2_rms", "mean_curvature_rms"}) {
        EXPECT_LT(m[key].get<double>(), 0.02) << key;
        EXPECT_NEAR(m[std::string(key) + "_x_diagonal"].get<double>(),
                    m[key].get<double>() * diagonal, 1e-12);
    }
    EXPECT_GT(m["l2"].get<double>(), 0);
}

TEST_F(MeasureStage, AnOffsetSphereIsAsFarAsItIsOff) {
    // Radius 1.01 against 1: every point 0.01 away along its normal, normals and curvature the
    // truth's.
    Cloud larger = cloud_;
    for (Vec3d& p : larger.positions) p *= 1.01;
    const auto m = measure(file("m.slim"), write(larger, "larger.ply"));
    EXPECT_EQ(m["missed"], 0);
    const double diagonal = m["diagonal"];
    EXPECT_NEAR(m["l2"].get<double>() * diagonal, 0.01, 2e-4);
    EXPECT_NEAR(m["max"].get<double>() * diagonal, 0.01, 2e-3);
}

TEST_F(MeasureStage, SaysWhichPointIsFarthest) {
    Cloud one_off = cloud_;
    one_off.positions[12345] *= 1.02;
    const auto m = measure(file("m.slim"), write(one_off, "one_off.ply"));
    for (std::size_t axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(m["max_at"][axis].get<double>(), one_off.positions[12345][axis], 1e-6);
}

TEST_F(MeasureStage, ACloudInAnotherFrameIsRefusedAndNothingIsWritten) {
    Cloud away = cloud_;
    for (Vec3d& p : away.positions) p += Vec3d{403000, 0, 0};
    MeasureConfig c;
    c.model = file("m.slim"), c.cloud = write(away, "away.ply");
    c.output = file("out.json"), c.per_point = file("points.ply");
    EXPECT_EQ(code_of([&] { run_as("measure", c, run_measure, listener_); }), ExitCode::numerical);
    for (const char* said :
         {"m.slim", "away.ply", "(402999", "(403001", "(403000, 0, 0)", "same frame?"})
        EXPECT_NE(message_.find(said), std::string::npos) << said << " in " << message_;
    for (const char* name : {"out.json", "out.json.done.json", "points.ply"})
        EXPECT_FALSE(std::filesystem::exists(file(name))) << name;
}

TEST_F(MeasureStage, ACloudInAnotherUnitIsToldSo) {
    Cloud millimetres = cloud_;
    for (Vec3d& p : millimetres.positions) p *= 1000;
    const std::string path = write(millimetres, "mm.ply");
    EXPECT_EQ(code_of([&] { measure(file("m.slim"), path); }), ExitCode::numerical);
    EXPECT_NE(message_.find("the cloud is 1000 times as large: are both in the same unit?"),
              std::string::npos)
        << message_;
}

TEST_F(MeasureStage, OnePointInReachIsEnough) {
    Cloud away = cloud_;
    for (std::size_t i = 1; i < away.size(); ++i) away.positions[i] += Vec3d{10, 0, 0};
    const auto m = measure(file("m.slim"), write(away, "away.ply"));
    EXPECT_EQ(m["missed"], 19999);
    EXPECT_LT(m["l2"].get<double>(), 1e-4);
}

TEST_F(MeasureStage, FlippedNormalsAreCountedAsOpposed) {
    Cloud flipped = cloud_;
    for (std::size_t i = 0; i < flipped.size(); i += 4) flipped.normals[i] = -flipped.normals[i];
    const auto m = measure(file("m.slim"), write(flipped, "flipped.ply"));
    EXPECT_EQ(m["opposed"], 5000);
    EXPECT_EQ(m["missed"], 0);
    EXPECT_LT(m["normal_rms_deg"].get<double>(), 0.5);
}

TEST_F(MeasureStage, ASupportedPointWithANormalAlongTheSurfaceIsAstrayNotMissed) {
    // Lifted off the sphere, the lines along their tangents miss it.
    Cloud tangent = cloud_;
    for (std::size_t i = 0; i < tangent.size(); i += 4) {
        const Vec3d outwards = normalized(to_double(cloud_.normals[i]));
        tangent.positions[i] += outwards * 0.01;
        tangent.normals[i] = to_float(frame_from_normal(outwards).u_axis);
    }
    const auto m = measure(file("m.slim"), write(tangent, "tangent.ply"));
    EXPECT_EQ(m["missed"], 0);
    EXPECT_EQ(m["astray"], 5000);
    EXPECT_NEAR(m["max"].get<double>() * m["diagonal"].get<double>(), 0.01, 1e-3);
}

TEST_F(MeasureStage, WithoutNormalsItProjectsAlongTheModels) {
    const auto with = measure(file("m.slim"), path_);
    const auto m = measure(file("m.slim"), write(cloud_, "bare.ply", false));
    EXPECT_EQ(m["without_normal"], 20000);
    EXPECT_EQ(m["missed"], 0);
    EXPECT_NEAR(m["l2"].get<double>() / with["l2"].get<double>(), 1, 0.01);
}

TEST_F(MeasureStage, TruthOfAnotherLengthIsRefused) {
    const Cloud few = sampled("sphere", 100);
    const std::string cloud = write(few, "few.ply");
    std::filesystem::resize_file(truth_path(cloud), 99 * 40);
    EXPECT_EQ(code_of([&] { measure(file("m.slim"), cloud); }), ExitCode::bad_data);
    std::filesystem::resize_file(truth_path(cloud), 101 * 40);
    EXPECT_EQ(code_of([&] { measure(file("m.slim"), cloud); }), ExitCode::bad_data);
    std::filesystem::remove(truth_path(cloud));
    EXPECT_FALSE(measure(file("m.slim"), cloud).contains("k1_rms"));
}

TEST_F(MeasureStage, NoFinitePointIsRefused) {
    const std::string bad = folder_.write("bad.xyz", "nan 0 0\n");
    EXPECT_EQ(code_of([&] { measure(file("m.slim"), bad); }), ExitCode::bad_data);
}

TEST_F(MeasureStage, AFileOfPointsUnderAnotherNameIsWrittenToo) {
    MeasureConfig c;
    c.model = file("m.slim"), c.cloud = path_, c.output = file("r.json");
    const auto measured = [&] { return run_as("measure", c, run_measure, listener_); };
    for (const char* name : {"a.ply", "b.ply"}) {
        c.per_point = file(name);
        EXPECT_FALSE(measured().contains("up_to_date")) << name;
        EXPECT_TRUE(std::filesystem::exists(file(name)));
    }
    EXPECT_TRUE(measured().contains("up_to_date"));
    c.per_point.clear();
    EXPECT_TRUE(measured().contains("up_to_date"));
}

TEST_F(MeasureStage, KeepsItsResultAndMeasuresAgainOnlyWhatChanged) {
    const std::string cloud = write(sampled("sphere", 3000), "c.ply");
    build(build_config(cloud, "m.slim"));
    MeasureConfig c;
    c.model = file("m.slim");
    c.cloud = cloud;
    c.output = file("measure.json");
    const auto first = run_as("measure", c, run_measure, listener_);
    EXPECT_FALSE(first.contains("up_to_date"));
    std::ifstream in(c.output);
    EXPECT_EQ(nlohmann::json::parse(in), first);
    const auto second = run_as("measure", c, run_measure, listener_);
    EXPECT_TRUE(second.contains("up_to_date"));
    EXPECT_EQ(second.at("l2"), first.at("l2"));
    write(sampled("sphere", 3100), "c.ply");
    EXPECT_FALSE(run_as("measure", c, run_measure, listener_).contains("up_to_date"));
}

}  // namespace
}  // namespace slim::test
