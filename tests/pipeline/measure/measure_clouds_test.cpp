#include "pipeline/measure/measure_clouds.h"

#include "pipeline/measure/measure_stage.h"
#include "tests/pipeline/build/fit_stages_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace slim::test {
namespace {

class MeasureClouds : public FitStages {
protected:
    nlohmann::json measure(const std::string& first, const std::string& second,
                           MeasureConfig c = {}) {
        c.model = first, c.cloud = second;
        return run_as("measure", c, run_measure, listener_);
    }
};

TEST_F(MeasureClouds, PointByPoint) {
    const std::string a = folder_.write("a.xyz", "0 0 0\n3 0 0\n3 4 0\n0 4 0\nnan 0 0\n"),
                      b = folder_.write("b.xyz", "0 0 0\n3 0 0\n3 4 0\n0 4 3\n1 1 1\n");
    MeasureConfig c;
    c.tolerance = 0.1;
    const auto said = measure(a, b, c);
    EXPECT_EQ(said["points"], 4);
    EXPECT_EQ(said["not_finite"], 1);
    EXPECT_DOUBLE_EQ(said["diagonal"], 5);
    EXPECT_DOUBLE_EQ(said["l2"], 0.3);  // 3 of 4 stay
    EXPECT_DOUBLE_EQ(said["max"], 0.6);
    EXPECT_EQ(said["max_at"], (nlohmann::json{0.0, 4.0, 0.0}));
    EXPECT_DOUBLE_EQ(said["within"], 0.75);
    EXPECT_FALSE(said.contains("normal_rms_deg"));
    EXPECT_FALSE(said.contains("first_to_second"));
}

TEST_F(MeasureClouds, TwoWayKnowsNoOrderAndNoNumber) {
    const std::string a = folder_.write("a.xyz", "0 0 0\n3 0 0\n3 4 0\n0 4 0\n"),
                      b = folder_.write("b.xyz", "0 4 0\n3 4 0\n3 0 0\n0 0 0\n0 0 5\n");
    MeasureConfig c;
    c.two_way = true;
    const auto said = measure(a, b, c);
    EXPECT_FALSE(said.contains("l2"));  // not as many: nothing point by point
    EXPECT_EQ(said["first_to_second"]["max"], 0);
    EXPECT_DOUBLE_EQ(said["second_to_first"]["max"], 1);
    EXPECT_EQ(said["second_to_first"]["points"], 5);
    EXPECT_DOUBLE_EQ(said["second_to_first"]["within"], 0.8);
    EXPECT_DOUBLE_EQ(said["second_to_first"]["l2"], std::sqrt(0.2));
    const auto same = measure(a, folder_.write("c.xyz", "0 4 0\n3 4 0\n3 0 0\n0 0 0\n"), c);
    EXPECT_DOUBLE_EQ(same["max"], 0.8);  // the first point's place is the last one's
    EXPECT_EQ(same["first_to_second"]["l2"], 0);
}

TEST_F(MeasureClouds, FiguresOfEveryPointWithNormals) {
    Cloud cloud = sampled("sphere", 300);
    const std::string a = write(cloud, "a.ply");
    for (Vec3d& p : cloud.positions) p += Vec3d{0, 0, 0.25};
    for (Vec3f& n : cloud.normals) n = -n;
    MeasureConfig c;
    c.per_point = file("p.ply");
    const auto said = measure(a, write(cloud, "b.ply"), c);
    EXPECT_NEAR(said["normal_mean_deg"].get<double>(), 180, 1e-3);
    const PointChunk written = read_all(file("p.ply"), 1000);
    EXPECT_EQ(written.position[7], cloud.positions[7]);
    const auto source = open_cloud(file("p.ply"));
    EXPECT_EQ(source->info().skipped,
              (std::vector<std::string>{"scalar_distance", "scalar_normal_angle", "quality"}));
    const std::string bytes = read_bytes(file("p.ply"));
    float scalars[3];
    std::memcpy(scalars, bytes.data() + bytes.size() - sizeof(scalars), sizeof(scalars));
    EXPECT_FLOAT_EQ(scalars[0], 0.25f);
    EXPECT_NEAR(scalars[1], 180, 1e-2);
}

TEST_F(MeasureClouds, WhatCannotBeComparedIsRefusedWithWhatCan) {
    const std::string a = folder_.write("a.xyz", "0 0 0\n3 0 0\n"),
                      b = folder_.write("b.xyz", "0 0 0\n3 0 0\n1 1 1\n");
    EXPECT_EQ(code_of([&] { measure(a, b); }), ExitCode::bad_data);
    for (const char* said : {"2 points", "3", "--two-way", "slim build"})
        EXPECT_NE(message_.find(said), std::string::npos) << said << " in " << message_;
    // A cloud beside itself is the mistake of one who has no model.
    EXPECT_EQ(code_of([&] { measure(a, a); }), ExitCode::bad_data);
    EXPECT_NE(message_.find("slim build"), std::string::npos) << message_;
    MeasureConfig c;
    c.samples = 10;
    EXPECT_EQ(code_of([&] { measure(a, b, c); }), ExitCode::usage);
    EXPECT_EQ(code_of([&] { measure(a, folder_.write("nan.xyz", "nan 0 0\nnan 1 1\n")); }),
              ExitCode::bad_data);
}

TEST_F(MeasureClouds, ExtentsWhoseSquaresAreNoNumbersAreRefused) {
    const std::string a = folder_.write("a.xyz", "0 0 0\n3 0 0\n");
    for (const bool two_way : {false, true})
        for (const char* points :
             {"1e200 0 0\n-1e200 0 0\n", "1e160 0 0\n0 0 0\n", "1e308 0 0\n-1e308 0 0\n"}) {
            const std::string far = folder_.write("far.xyz", points);
            MeasureConfig c;
            c.two_way = two_way;
            for (const auto& [first, second] : {std::pair(far, a), std::pair(a, far)}) {
                EXPECT_EQ(code_of([&] { measure(first, second, c); }), ExitCode::bad_data)
                    << points;
                EXPECT_NE(message_.find("far.xyz"), std::string::npos) << message_;
                EXPECT_NE(message_.find("overflows"), std::string::npos) << message_;
            }
        }
    const std::string tiny = folder_.write("tiny.xyz", "0 0 0\n1e-200 0 0\n"),
                      speck = folder_.write("b.xyz", "0 0 0\n0 1e-200 0\n");
    EXPECT_EQ(code_of([&] { measure(tiny, speck); }), ExitCode::bad_data);
    EXPECT_NE(message_.find("vanishes"), std::string::npos) << message_;
    EXPECT_EQ(measure(a, folder_.write("wide.xyz", "1e100 0 0\n3 0 0\n"))["points"], 2);
}

TEST_F(MeasureClouds, CloudsWithoutAPointThatIsFiniteInBothAreRefused) {
    const std::string a = folder_.write("a.xyz", "nan 0 0\n0 0 0\n"),
                      b = folder_.write("b.xyz", "0 0 0\nnan 0 0\n");
    MeasureConfig c;
    c.per_point = file("p.ply");
    EXPECT_EQ(code_of([&] { measure(a, b, c); }), ExitCode::bad_data);
    for (const char* said : {"a.xyz", "b.xyz", "finite in both", "--two-way"})
        EXPECT_NE(message_.find(said), std::string::npos) << message_;
    EXPECT_EQ(folder_.n_files(), 2u);
    MeasureConfig any;
    any.two_way = true;
    EXPECT_EQ(measure(a, b, any)["first_to_second"]["max"], nullptr);  // L is 0
    EXPECT_EQ(measure(a, b, any)["first_to_second"]["points"], 1);
}

TEST_F(MeasureClouds, AMeshIsACloudOfItsVerticesBesideOneWhereOrderDoesNotMatter) {
    const std::string four = folder_.write("four.xyz", "0 0 0\n3 0 0\n3 4 0\n0 4 0\n");
    const std::string tri = folder_.write(
        "tri.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\n"
        "property double z\nelement face 1\nproperty list uchar int vertex_indices\n"
        "end_header\n0 0 0\n3 0 0\n3 4 0\n3 0 1 2\n");
    MeasureConfig c;
    c.two_way = true;
    const auto one = measure(four, tri, c), other = measure(tri, four, c);
    EXPECT_DOUBLE_EQ(one["first_to_second"]["max"], 0.6);
    EXPECT_EQ(one["first_to_second"], other["second_to_first"]);
    EXPECT_EQ(one["second_to_first"], other["first_to_second"]);
    EXPECT_EQ(code_of([&] { measure(tri, four); }), ExitCode::bad_data);
    for (const char* said : {"3 vertices", "tri.ply has faces", "--two-way"})
        EXPECT_NE(message_.find(said), std::string::npos) << message_;
    EXPECT_EQ(code_of([&] { measure(tri, folder_.write("u.ply", read_bytes(tri)), c); }),
              ExitCode::usage);
    EXPECT_NE(message_.find("the first has faces"), std::string::npos) << message_;
}

TEST_F(MeasureClouds, NamesThatCannotBeWrittenAreRefusedBeforeAnyWork) {
    const std::string a = folder_.write("a.xyz", "0 0 0\n3 0 0\n"),
                      b = folder_.write("b.xyz", "0 0 1\n3 0 0\n");
    const auto refused = [&](const char* output, const char* per_point, const std::string& said) {
        MeasureConfig c;
        if (*output) c.output = file(output);
        if (*per_point) c.per_point = file(per_point);
        EXPECT_EQ(code_of([&] { measure(a, b, c); }), ExitCode::usage) << output << per_point;
        EXPECT_NE(message_.find(said), std::string::npos) << message_;
    };
    refused("diff.txt", "", "expected a name ending in .json");
    refused("diff", "", "expected a name ending in .json");
    refused("d.png", "", "a picture only of two pictures");
    refused("", "p.xyz", "expected a name ending in .ply");
    EXPECT_EQ(folder_.n_files(), 2u);
    MeasureConfig c;
    c.output = file("d.JSON");
    measure(a, b, c);
    EXPECT_EQ(measure(a, b, c)["up_to_date"], true);
}

TEST_F(MeasureClouds, ABrokenCloudInPlaceOfTheModelIsNamedWithItsFault) {
    const std::string broken =
        folder_.write("broken.ply", "ply\nformat ascii 1.0\nelement vertex 2\nproperty foo x\n");
    const std::string text = folder_.write("text.xyz", "1 2 3\n4 5 x\n");
    for (const std::string& path : {broken, text}) {
        EXPECT_NE(code_of([&] { measure(path, path); }), ExitCode::ok);
        EXPECT_EQ(message_.find("SLIM model"), std::string::npos) << message_;
    }
    code_of([&] { measure(broken, broken); });
    EXPECT_NE(message_.find("line 4"), std::string::npos) << message_;
    EXPECT_NE(message_.find("'foo'"), std::string::npos) << message_;
}

}  // namespace
}  // namespace slim::test
