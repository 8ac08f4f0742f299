#include "pipeline/build/build_stage.h"

#include "pipeline/measure/measure_stage.h"
#include "tests/pipeline/build/fit_stages_support.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

namespace slim::test {
namespace {

class BuildMeshes : public FitStages {
protected:
    nlohmann::json both_ways(const std::string& model, const std::string& mesh) {
        MeasureConfig c;
        c.model = model, c.cloud = mesh, c.two_way = true;
        return run_as("measure", c, run_measure, listener_);
    }
};

/// Of 6 quadrangles, wound outwards.
std::string box(double a, double b, double c) {
    std::string text =
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty "
        "float z\n"
        "element face 6\nproperty list uchar int vertex_indices\nend_header\n";
    for (int i = 0; i < 8; ++i)
        text += fmt::format("{} {} {}\n", a * (i >> 2 & 1), b * (i >> 1 & 1), c * (i & 1));
    return text + "4 0 1 3 2\n4 4 6 7 5\n4 0 4 5 1\n4 2 3 7 6\n4 0 2 6 4\n4 1 5 7 3\n";
}

TEST_F(BuildMeshes, LargeFacesOfAMeshGetPointsOfTheirOwn) {
    const std::string cube = folder_.write("cube.ply", box(1, 1, 1));
    auto config = build_config(cube, "cube.slim");
    config.sharp = "on";
    const auto built = build(config);
    EXPECT_GT(built["stages"]["slice"]["face_points"], 5000);
    EXPECT_GT(built["leaves"], 100);
    EXPECT_LT(measure(file("cube.slim"), cube)["max"].get<double>(), 1e-3);  // the corners
    config.slices = 3, config.memory = "64MiB";  // dealt out in a second reading
    EXPECT_EQ(build(config)["points"], built["points"]);
    config.face_points = "off";
    EXPECT_EQ(build(config)["points"], 8);
}

TEST_F(BuildMeshes, NoDiscStandsOutOfAThinPlate) {
    for (const double thickness : {3.0, 1.0}) {
        SCOPED_TRACE(thickness);
        const std::string plate = folder_.write("plate.ply", box(100, 60, thickness));
        auto config = build_config(plate, "plate.slim");
        config.sharp = "on";
        build(config);
        EXPECT_TRUE(listener_.warnings.empty());
        const auto m = both_ways(file("plate.slim"), plate);
        // 0.04 of the diagonal before points were as dense as plates are thin.
        EXPECT_LT(m["model_to_cloud"]["max"].get<double>(), 1e-3);
        EXPECT_LT(m["faces"]["max"].get<double>(), 1e-3);
        EXPECT_EQ(m["faces"]["missed"], 0);
    }
}

TEST_F(BuildMeshes, TheVerticesOfAnOctahedronAreSharp) {
    const std::string mesh = folder_.write(
        "octahedron.ply",
        "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty "
        "float z\nelement face 8\nproperty list uchar int vertex_indices\nend_header\n"
        "1 0 0\n-1 0 0\n0 1 0\n0 -1 0\n0 0 1\n0 0 -1\n3 0 2 4\n3 2 1 4\n3 1 3 4\n3 3 0 4\n"
        "3 2 0 5\n3 1 2 5\n3 3 1 5\n3 0 3 5\n");
    build(build_config(mesh, "octahedron.slim"));
    const auto m = both_ways(file("octahedron.slim"), mesh);
    // 8e-3 of the diagonal while leaves held three sheets at most.
    EXPECT_LT(m["model_to_cloud"]["max"].get<double>(), 1e-3);
    EXPECT_LT(m["faces"]["max"].get<double>(), 1e-3);
    EXPECT_EQ(m["faces"]["missed"], 0);
}

TEST_F(BuildMeshes, APlateTooThinForItsPointsIsToldOf) {
    auto config = build_config(folder_.write("sheet.ply", box(1000, 600, 0.1)), "sheet.slim");
    config.sharp = "on";
    build(config);
    ASSERT_EQ(listener_.warnings.size(), 1u);
    EXPECT_NE(listener_.warnings[0].find("sheet.ply: parts thinner than"), std::string::npos)
        << listener_.warnings[0];
}

}  // namespace
}  // namespace slim::test
