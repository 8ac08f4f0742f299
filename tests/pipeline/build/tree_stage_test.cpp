#include "pipeline/build/tree_stage.h"

#include "formats/fit_file.h"
#include "formats/model_file.h"
#include "tests/pipeline/build/fit_stages_support.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

namespace slim::test {
namespace {

namespace fs = std::filesystem;

class TreeStage : public FitStages {};

TEST_F(TreeStage, MissingFitsAreExit6AndNamed) {
    slice(write(sampled("sphere", 3000), "c.ply"), 2);
    normals();
    EXPECT_EQ(code_of([&] { tree("m.slim"); }), ExitCode::incomplete);
    fit();
    fs::remove(fs::path(fit_path(file("work"), 1).string() + ".done.json"));
    EXPECT_EQ(code_of([&] { tree("m.slim"); }), ExitCode::incomplete);
    EXPECT_NE(message_.find(fit_path(file("work"), 1).string()), std::string::npos) << message_;
    EXPECT_FALSE(fs::exists(file("m.slim")));
}

TEST_F(TreeStage, FitsOfDifferentSettingsAreNotMixed) {
    slice(write(sampled("sphere", 3000), "c.ply"), 2);
    normals();
    fit();
    FitConfig other;
    other.t_mdl = 0.05;
    other.slice = 1;
    fit(other);
    EXPECT_EQ(code_of([&] { tree("m.slim"); }), ExitCode::incomplete);
    EXPECT_NE(message_.find("other settings"), std::string::npos) << message_;
    EXPECT_NE(message_.find("t_mdl 0.01, not 0.05: run `slim fit"), std::string::npos) << message_;
    EXPECT_EQ(message_.find('{'), std::string::npos) << message_;
    other.slice = -1;
    fit(other);
    EXPECT_EQ(code_of([&] { tree("m.slim"); }), ExitCode::ok) << message_;
    EXPECT_EQ(ModelFile::open(file("m.slim")).header().mdl_threshold, 0.05);
}

TEST_F(TreeStage, ACloudMovedByItsOriginMovesTheModel) {
    Cloud cloud = sampled("sphere", 3000);
    for (Vec3d& p : cloud.positions)  // moved without rounding
        p = {std::round(p.x * 4096) / 4096, std::round(p.y * 4096) / 4096,
             std::round(p.z * 4096) / 4096};
    const auto model_of = [&](const char* name) {
        slice(write(cloud, name), 1);
        normals();
        fit();
        tree("m.slim");
        return ModelFile::open(file("m.slim")).header();
    };
    const ModelHeader before = model_of("a.ply");
    for (Vec3d& p : cloud.positions) p.x += 4096;
    const ModelHeader after = model_of("b.ply");
    EXPECT_EQ(after.bounds.lo, before.bounds.lo);  // the same fit
    EXPECT_EQ(after.origin.x - before.origin.x, 4096);
}

TEST_F(TreeStage, RefusesFitsThatDoNotSayWhatTheyAre) {
    slice(write(sampled("sphere", 3000), "c.ply"), 1);
    normals();
    fit();
    const std::string path = fit_path(file("work"), 0).string();
    for (const char* header : {"no json", "[]", "{}", R"({"rules": {"degree": 12}, "counts": {}})",
                               R"({"rules": {"degree": "2"}, "counts": {}})"}) {
        write_fit(path, read_fit(path).surfels, header);
        EXPECT_EQ(code_of([&] { tree("m.slim"); }), ExitCode::bad_data) << header;
        EXPECT_NE(message_.find(path), std::string::npos) << message_;
    }
}

TEST_F(TreeStage, FitsWithoutASurfelSayWhatBecameOfTheCloud) {
    slice(write(sampled("sphere", 3000), "c.ply"), 1);
    normals();
    fit();
    const std::string path = fit_path(file("work"), 0).string();
    const auto told = [&](const char* counts) {
        write_fit(path, {}, fmt::format(R"({{"rules": {{"degree": 2}}, "counts": {}}})", counts));
        EXPECT_EQ(code_of([&] { tree("m.slim"); }), ExitCode::bad_data);
        EXPECT_NE(message_.find("c.ply: the fit left no surfel of 3000 points"), std::string::npos)
            << message_;
        return message_;
    };
    const std::string isolated =
        told(R"({"leaves": 0, "dropped_isolated": 2900, "dropped_unexplained": 70})");
    EXPECT_NE(isolated.find("2900 with too few neighbours, 70 that no surfel explains"),
              std::string::npos)
        << isolated;
    EXPECT_NE(isolated.find("take out strays"), std::string::npos) << isolated;
    const std::string unexplained =
        told(R"({"leaves": 0, "dropped_isolated": 5, "dropped_unexplained": 2995})");
    EXPECT_NE(unexplained.find("--normals estimate"), std::string::npos) << unexplained;
    EXPECT_NE(told(R"({"leaves": 0})").find("none was dropped"), std::string::npos);
}

TEST_F(TreeStage, TheModelSaysWhatItWasMadeOf) {
    slice(write(sampled("sphere", 5000), "c.ply"), 1);
    normals();
    const auto fitted = fit();
    const auto r = tree("m.slim");
    const ModelFile model = ModelFile::open(file("m.slim"));
    EXPECT_EQ(r["leaves"], fitted["leaves"]);
    EXPECT_EQ(model.header().n_leaves, fitted["leaves"]);
    EXPECT_EQ(r["nodes"], model.tree().n_nodes());
    EXPECT_EQ(model.header().noise_variance, fitted["noise_variance"]);
    const auto provenance = nlohmann::json::parse(model.provenance_json());
    EXPECT_EQ(provenance["inputs"][0]["points"], 5000);
    EXPECT_EQ(provenance["rules"]["t_mdl"], 0.01);
    EXPECT_EQ(provenance.dump().find("work"), std::string::npos);  // no paths in the model
    EXPECT_TRUE(tree("m.slim").value("up_to_date", false));
}

TEST_F(TreeStage, MarksLooseLeavesAndCountsThem) {
    // A sphere and a tuft of points upright on it, a twentieth as dense.
    Cloud cloud = sampled("sphere", 20000);
    for (int i = 0; i < 12; ++i) {
        cloud.positions.push_back({1.12 + 0.02 * (i % 4), 0.02 * (i / 4), 0});
        cloud.normals.push_back({0, 0, 1});
        cloud.scan_ids.push_back(0);
    }
    slice(write(cloud, "c.ply"), 1);
    normals();
    fit();
    const auto r = tree("m.slim");
    const ModelFile model = ModelFile::open(file("m.slim"));
    std::uint64_t loose = 0, leaves = 0;
    for (const TreeNode& node : model.tree().nodes()) {
        if (!node.is_leaf()) continue;
        ++leaves;
        loose += node.is_loose();
    }
    EXPECT_EQ(r["loose"], loose);
    EXPECT_GE(loose, 1u);
    EXPECT_LT(loose, leaves / 4);
    EXPECT_EQ(r["leaves"], leaves);  // loose ones are leaves still
}

TEST_F(TreeStage, WarnsOnceWhatMemoryTheTreeWouldTakeAndBuildsIt) {
    slice(write(sampled("sphere", 5000), "c.ply"), 1);
    normals();
    fit();
    listener_.warnings.clear();
    TreeConfig c;
    c.work = file("work");
    c.output = file("m.slim");
    run_as("tree", c, run_tree, listener_);
    EXPECT_TRUE(listener_.warnings.empty());
    c.memory = "1MiB";
    const auto r = run_as("tree", c, run_tree, listener_);
    ASSERT_EQ(listener_.warnings.size(), 1u);
    const std::string& warning = listener_.warnings[0];
    EXPECT_NE(warning.find("more than --memory 1MiB: --memory 17MiB would do"), std::string::npos)
        << warning;
    EXPECT_GT(r["leaves"], 0);
    listener_.warnings.clear();
    c.memory = "17MiB";
    run_as("tree", c, run_tree, listener_);
    EXPECT_TRUE(listener_.warnings.empty());
}

}  // namespace
}  // namespace slim::test
