#include "formats/atomic_file.h"
#include "formats/model_file.h"
#include "pipeline/build/build_summary.h"
#include "pipeline/info/info_stage.h"
#include "pipeline/input_kind.h"
#include "pipeline/manifest.h"
#include "slim/base/hash.h"
#include "slim/fit/edge_share.h"
#include "tests/pipeline/build/build_stage_support.h"
#include "tests/pipeline/build/fit_stages_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>

// When edges get sharp surfels, and what is said of it.

namespace slim::test {
namespace {

/// Nobody asks the points for edges that the paper's windows have no leaves for.
TEST_F(BuildStage, WindowsHaveNoSharpSurfelsByDefault) {
    auto config = build_config(folder_.write("cube.xyz", cube_text(24)), "m.slim");
    config.radius_rule = "windows";
    const auto result = build(config);
    EXPECT_EQ(result["sharp"], false);
    EXPECT_FALSE(result.contains("edge_share"));
}

TEST_F(BuildStage, AMeshOfLargeFacesIsSharpHoweverThinItIs) {
    // 100 x 60 x 10: in a ball that shows an edge the two sides are back to back.
    const std::string box = folder_.write(
        "box.ply",
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
        "property float z\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n100 0 0\n100 60 0\n0 60 0\n0 0 10\n100 0 10\n100 60 10\n0 60 10\n"
        "4 0 3 2 1\n4 0 1 5 4\n4 2 3 7 6\n4 1 2 6 5\n4 0 4 7 3\n4 4 5 6 7\n");
    for (const int slices : {1, 3}) {
        SCOPED_TRACE(slices);
        auto config = build_config(box, "box.slim");
        config.slices = slices;
        const auto result = build(config);
        EXPECT_EQ(result["sharp"], true);
        EXPECT_EQ(result["sharp_by_faces"], true);
        EXPECT_FALSE(result.contains("edge_share"));
        EXPECT_NE(build_summary(config.output, config.inputs, result).find("mesh of large faces"),
                  std::string::npos);
        EXPECT_LT(measure(config.output, box)["faces"]["max"].get<double>(), 1e-3);
        const std::string by_itself = hash_file(config.output);
        config.sharp = "on", config.output = file("on.slim");
        EXPECT_FALSE(build(config).contains("sharp_by_faces"));
        EXPECT_EQ(hash_file(config.output), by_itself);
    }
}

/// By default the points decide about sharp surfels: the model is, bit by bit, that of the option
/// that comes to the same, and the number that decided is said.
TEST_F(BuildStage, ThePointsDecideAboutSharpSurfels) {
    const std::string cube = folder_.write("cube.xyz", cube_text(24)), ball = scanned_sphere(5000);
    for (const std::string& cloud : {cube, ball})
        for (const int slices : {1, 3}) {
            SCOPED_TRACE(testing::Message() << cloud << ", slices " << slices);
            const bool is_part = cloud == cube;
            auto config = build_config(cloud, "told.slim");
            config.slices = slices;
            config.sharp = is_part ? "on" : "off";
            EXPECT_FALSE(build(config).contains("edge_share"));
            config.sharp = BuildConfig{}.sharp;
            config.output = file("m.slim");
            const auto result = build(config);
            EXPECT_EQ(result["sharp"], is_part);
            EXPECT_EQ(result["edge_share"].get<double>() > kEdgeShare, is_part) << result;
            EXPECT_GE(result["edge_places"].get<int>(), 32);
            EXPECT_EQ(hash_file(file("m.slim")), hash_file(file("told.slim")));

            InfoConfig info;
            info.file = config.output;
            Reporter silent;
            const auto said = run_as("info", info, run_info, silent)["fit"];
            EXPECT_EQ(said["sharp"], is_part);
            EXPECT_EQ(said["edge_share"], result["edge_share"]);
            const std::string manifest = manifest_path(config.output).string();
            const std::string written = read_bytes(manifest);
            std::string edited = written;
            const std::string key = "\"xxh3_128\":";
            edited.insert(edited.find(key, edited.find("\"outputs\"")) + key.size(), "5, \"was\":");
            write_file_atomically(manifest, edited);
            EXPECT_FALSE(run_as("info", info, run_info, silent)["fit"].contains("edge_share"));
            write_file_atomically(manifest, written);
            config.t_mdl = 0.02, config.output = file("other.slim");
            build(config);
            std::filesystem::rename(file("other.slim"), file("m.slim"));
            const auto of_another = run_as("info", info, run_info, silent)["fit"];
            EXPECT_FALSE(of_another.contains("edge_share")) << of_another;
        }
}

TEST_F(BuildStage, AStepOfAJobNamesTheJobsKey) {
    const std::string cube = folder_.write("cube.xyz", cube_text(24));
    const auto said = [&] {
        listener_.infos.clear();
        build(build_config(cube, "m.slim"));
        std::string all;
        for (const std::string& info : listener_.infos) all += info + "\n";
        std::filesystem::remove(manifest_path(file("m.slim")));
        return all;
    };
    EXPECT_EQ(said().find("sharp surfels"), std::string::npos);  // once, in the summary
    const auto result = build(build_config(cube, "m.slim"));
    const std::string summary = build_summary(file("m.slim"), {cube}, result);
    EXPECT_NE(summary.find("with sharp surfels (--sharp off: without)"), std::string::npos);
    std::filesystem::remove(manifest_path(file("m.slim")));
    setenv(kErrorsByParent, "1", 1);
    const std::string in_a_job = said();
    unsetenv(kErrorsByParent);
    EXPECT_NE(in_a_job.find("with sharp surfels (fit.sharp = \"off\": without)"),
              std::string::npos)
        << in_a_job;
    EXPECT_EQ(in_a_job.find("--sharp"), std::string::npos) << in_a_job;
}

TEST_F(BuildStage, TheStagesByThemselvesDecideAsABuildDoes) {
    const std::string cube = folder_.write("cube.xyz", cube_text(24));
    build(build_config(cube, "m.slim"));
    for (const int slices : {1, 3}) {
        SCOPED_TRACE(testing::Message() << "slices " << slices);
        slice(cube, slices);
        normals();
        listener_.infos.clear();
        for (int i = slices; i-- > 0;) {  // in any order, each by itself
            FitConfig config;
            config.slice = i;
            EXPECT_EQ(fit(config)["sharp"], true);
        }
        const auto& infos = listener_.infos;
        EXPECT_TRUE(std::any_of(infos.begin(), infos.end(), [](const std::string& s) {
            return s.find("sharp edges: at ") == 0;
        }));
        tree("staged.slim");
        EXPECT_FALSE(ModelFile::open(file("staged.slim")).tree().sharp().empty());
        if (slices == 1) { EXPECT_EQ(hash_file(file("staged.slim")), hash_file(file("m.slim"))); }
        std::filesystem::remove_all(file("work"));
    }
}

TEST_F(BuildStage, SharpIsExactOnACubeInAnySlicesAndDegree) {
    const std::string cloud = folder_.write("cube.xyz", cube_text(24));
    for (const int degree : {1, 2, 3})
        for (const int slices : {1, 3}) {
            SCOPED_TRACE(testing::Message() << "degree " << degree << ", slices " << slices);
            auto config = build_config(cloud, "m.slim");
            config.degree = std::to_string(degree);
            config.slices = slices;
            config.sharp = "off";
            const auto smooth = build(config), smooth_error = measure(config.output, cloud);
            EXPECT_TRUE(ModelFile::open(config.output).tree().sharp().empty());
            config.sharp = "on";
            const auto sharp = build(config), sharp_error = measure(config.output, cloud);
            EXPECT_GE(ModelFile::open(config.output).tree().sharp().size(), 20u);
            // Smooth leaves that a fold ended are as few (slim/cover/notes/0012),
            // and round the edges off.
            EXPECT_LT(sharp["leaves"].get<int>(), 1.25 * smooth["leaves"].get<int>());
            EXPECT_LT(sharp_error["l2"].get<double>(), 0.1 * smooth_error["l2"].get<double>());
            // Floats of the file, 6e-8 of a radius; one place of the linear model still has a
            // smooth leaf.
            EXPECT_LT(sharp_error["max"].get<double>(),
                      degree == 1 ? 0.5 * smooth_error["max"].get<double>() : 1e-7);
        }
}

}  // namespace
}  // namespace slim::test
