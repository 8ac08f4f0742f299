#include "pipeline/build/build_stage.h"

#include "tests/pipeline/build/fit_stages_support.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

namespace slim::test {
namespace {

class BuildMeshes : public FitStages {};

TEST_F(BuildMeshes, LargeFacesOfAMeshGetPointsOfTheirOwn) {
    std::string text =
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty "
        "float z\n"
        "element face 6\nproperty list uchar int vertex_indices\nend_header\n";
    for (int i = 0; i < 8; ++i) text += fmt::format("{} {} {}\n", i >> 2 & 1, i >> 1 & 1, i & 1);
    text += "4 0 1 3 2\n4 4 6 7 5\n4 0 4 5 1\n4 2 3 7 6\n4 0 2 6 4\n4 1 5 7 3\n";
    const std::string cube = folder_.write("cube.ply", text);
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

}  // namespace
}  // namespace slim::test
