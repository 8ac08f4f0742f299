#include "pipeline/build/build_stage.h"

#include "formats/model_file.h"
#include "formats/slice_file.h"
#include "pipeline/info/info_stage.h"
#include "pipeline/input_kind.h"
#include "pipeline/manifest.h"
#include "pipeline/scan_stage.h"
#include "pipeline/signals.h"
#include "pipeline/smooth/smooth_stage.h"
#include "slim/base/parallel.h"
#include "tests/pipeline/build/build_stage_support.h"
#include "tests/pipeline/build/fit_stages_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <utility>

namespace slim::test {
namespace {

namespace fs = std::filesystem;

TEST_F(BuildStage, MakesAModelOfAScannedSphere) {
    const std::string cloud = scanned_sphere(20000);
    const auto result = build(build_config(cloud, "m.slim"));
    const ModelFile model = ModelFile::open(file("m.slim"));
    EXPECT_EQ(result["leaves"], model.header().n_leaves);
    EXPECT_EQ(result["points"], 20000);
    EXPECT_EQ(model.header().degree, 2);
    EXPECT_EQ(model.header().mdl_threshold, 0.01);
    EXPECT_EQ(model.header().n_points, 20000u);
    EXPECT_NEAR(model.header().diagonal, std::sqrt(12.0), 0.02);
    EXPECT_GT(model.header().n_leaves, 100u);
    EXPECT_LT(model.header().n_leaves, 2000u);
    EXPECT_FALSE(fs::exists(file("m.slim.work")));
    const auto measured = measure(file("m.slim"), cloud);
    EXPECT_EQ(measured["missed"], 0);
    EXPECT_LT(measured["l2"].get<double>(), 1e-4);
}

TEST_F(BuildStage, SaysUpToDateAndRebuildsWhenAnOptionChanges) {
    auto config = build_config(scanned_sphere(5000), "m.slim");
    const auto first = build(config);
    EXPECT_FALSE(first.contains("up_to_date"));
    const auto second = build(config);
    EXPECT_TRUE(second.value("up_to_date", false));
    EXPECT_EQ(second["leaves"], first["leaves"]);
    const std::string before = read_bytes(file("m.slim"));
    config.t_mdl = 0.001;
    const auto third = build(config);
    EXPECT_FALSE(third.contains("up_to_date"));
    EXPECT_GT(third["leaves"].get<int>(), first["leaves"].get<int>());
    EXPECT_NE(read_bytes(file("m.slim")), before);
}

TEST_F(BuildStage, AWorkFolderThatIsAskedForLaterIsThere) {
    BuildConfig c = build_config(write(sampled("sphere", 3000), "c.ply"), "m.slim");
    EXPECT_FALSE(build(c).contains("up_to_date"));
    EXPECT_TRUE(build(c).contains("up_to_date"));
    c.work = file("WK");
    EXPECT_FALSE(build(c).contains("up_to_date"));
    EXPECT_TRUE(std::filesystem::exists(plan_path(file("WK"))));
    EXPECT_TRUE(build(c).contains("up_to_date"));
    std::filesystem::remove_all(file("WK"));
    c.work.clear();
    EXPECT_TRUE(build(c).contains("up_to_date"));
}

TEST_F(BuildStage, ABuildThatIsUpToDateLeavesWhatOthersSliced) {
    BuildConfig c = build_config(write(sampled("sphere", 3000), "c.ply"), "m.slim");
    c.work = file("m.slim.work");  // as plans for make name it
    build(c);
    c.work.clear();
    EXPECT_TRUE(build(c).contains("up_to_date"));
    EXPECT_TRUE(fs::exists(plan_path(file("m.slim.work"))));
}

TEST_F(BuildStage, WhatAKillLeftOfAFinishedBuildGoes) {
    const BuildConfig c = build_config(write(sampled("sphere", 3000), "c.ply"), "m.slim");
    build(c);
    EXPECT_FALSE(fs::exists(file("m.slim.work.done")));
    fs::create_directories(file("m.slim.work.done/slice_0000"));
    folder_.write("m.slim.work.done/made_by_slim_build", "");
    EXPECT_TRUE(build(c).contains("up_to_date"));
    EXPECT_FALSE(fs::exists(file("m.slim.work.done")));
}

/// Ends a build between its tree and its record, as a kill may.
class StopsAfterTheTree : public Listener {
public:
    void info(const std::string& text) override {
        if (text.starts_with("tree: ")) throw Interrupted(ExitCode::terminated);
        Listener::info(text);
    }
};

// A make that goes on after a kill took the tree's record for the build's: the page's build was
// then done again, and everything that is made of the model at the next make; colours were missing.
TEST_F(BuildStage, AModelWithoutTheRestOfItsBuildHasNoRecord) {
    BuildConfig c = build_config(write(sampled("sphere", 3000), "c.ply"), "m.slim");
    c.slices = 2;
    StopsAfterTheTree listener;
    EXPECT_EQ(code_of([&] { run_as("build", c, run_build, listener); }), ExitCode::terminated);
    EXPECT_TRUE(fs::exists(file("m.slim")) && fs::exists(file("m.slim.work/tree.done.json")));
    EXPECT_FALSE(fs::exists(file("m.slim.done.json")));
    build(c);
    EXPECT_NE(std::find(listener_.infos.begin(), listener_.infos.end(), "tree: up to date"),
              listener_.infos.end())
        << "the tree is done again";
    EXPECT_TRUE(fs::exists(file("m.slim.done.json")));
    EXPECT_FALSE(fs::exists(file("m.slim.work")));
}

/// Puts a folder where the record of a build is to be renamed to, when its model is done.
class ObstructsTheRecord : public Listener {
public:
    explicit ObstructsTheRecord(fs::path record) : record_(std::move(record)) {}
    void info(const std::string& text) override {
        if (text.starts_with("tree: ")) fs::create_directory(record_);
        Listener::info(text);
    }

private:
    fs::path record_;
};

TEST_F(BuildStage, ARecordThatCannotBeWrittenLosesNothingOfTheWork) {
    BuildConfig c = build_config(write(sampled("sphere", 3000), "c.ply"), "m.slim");
    c.slices = 2;
    build(c);
    const std::string undisturbed = read_bytes(file("m.slim"));
    fs::remove(file("m.slim")), fs::remove(file("m.slim.done.json"));

    ObstructsTheRecord listener(file("m.slim.done.json"));
    try {
        run_as("build", c, run_build, listener);
        FAIL() << "a build without a record is taken for done";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("goes on where it was"), std::string::npos)
            << error.what();
    }
    EXPECT_FALSE(fs::exists(file("m.slim.work.done")));
    for (const char* left : {"made_by_slim_build", "plan.json", "slice_0001/surfels.fit"})
        EXPECT_TRUE(fs::exists(file("m.slim.work") + "/" + left)) << left;
    // It is said at once the next time, and costs nothing of what is there.
    EXPECT_EQ(code_of([&] { build(c); }), ExitCode::usage);
    EXPECT_TRUE(fs::exists(file("m.slim.work/slice_0001/surfels.fit")));

    fs::remove(file("m.slim.done.json"));
    listener_.infos.clear();
    build(c);
    for (const char* stage : {"slice", "normals", "fit"})
        EXPECT_NE(std::find(listener_.infos.begin(), listener_.infos.end(),
                            std::string(stage) + ": up to date"),
                  listener_.infos.end())
            << stage << " is done again";
    EXPECT_EQ(read_bytes(file("m.slim")), undisturbed);
    EXPECT_FALSE(fs::exists(file("m.slim.work")) || fs::exists(file("m.slim.work.done")));
}

TEST_F(BuildStage, AModelHasNoOtherFormatsEnding) {
    const std::string cloud = write(sampled("sphere", 3000), "c.ply");
    for (const char* name : {"m.ply", "m.PNG", "m.json", "m.slim.gz"}) {
        EXPECT_EQ(code_of([&] { build(build_config(cloud, name)); }), ExitCode::usage) << name;
        EXPECT_NE(message_.find("ending in .slim"), std::string::npos) << message_;
        EXPECT_FALSE(fs::exists(file(name)));
    }
    for (const char* name : {"m", "t_0.01", "m.slim"})
        EXPECT_NO_THROW(build(build_config(cloud, name))) << name;
    EXPECT_GT(measure(file("t_0.01"), cloud)["leaves"], 0);
}

TEST_F(BuildStage, NoiseIsOverTheDiagonalForAllVerbs) {
    ScanConfig s;
    s.shape = "torus", s.output = file("c.ply"), s.points = 20000, s.noise = 0.003;
    s.pattern = "uniform", s.noise_model = "isotropic";
    const std::string cloud = s.output;
    const double diagonal_of_shape = run_as("scan", s, run_scan, listener_)["diagonal"];
    ASSERT_GT(diagonal_of_shape, 3);  // so that a figure in the cloud's unit would be another
    const auto built = build(build_config(cloud, "m.slim"));
    InfoConfig c;
    c.file = file("m.slim");
    const auto info = run_as("info", c, run_info, listener_);
    EXPECT_DOUBLE_EQ(built["noise"].get<double>(), info["noise"].get<double>());
    EXPECT_NEAR(info["noise"].get<double>(), 0.003, 0.0006);
    const double diagonal = info["diagonal"];
    EXPECT_NEAR(std::sqrt(built["noise_variance"].get<double>()) / diagonal,
                info["noise"].get<double>(), 1e-12);
    SmoothConfig m;
    m.model = file("m.slim"), m.cloud = cloud, m.output = file("s.ply");
    EXPECT_NEAR(run_as("smooth", m, run_smooth, listener_)["noise"].get<double>(), 0.003, 0.0006);
}

TEST_F(BuildStage, InfoSaysThingsOnceAndLevelsInOrder) {
    build(build_config(write(sampled("sphere", 3000), "c.ply"), "m.slim"));
    InfoConfig c;
    c.file = file("m.slim");
    StageContext context{listener_, 1, false, "info"};
    const auto whole = run_info(c, context);
    EXPECT_TRUE(whole["provenance"].contains("fits"));  // --json has it
    const auto times_said = [&](const std::string& key) {
        std::size_t n = 0;
        for (std::size_t at = 0; (at = context.text.find(key + "  ", at)) != std::string::npos;
             ++at)
            ++n;
        return n;
    };
    for (const char* key : {"diagonal", "degree", "t_mdl"})
        EXPECT_EQ(times_said(key), 1u) << key << " in\n" << context.text;
    EXPECT_EQ(times_said("noise_variance"), 0u) << context.text;  // noise says it, over L
    EXPECT_NE(context.text.find("noise "), std::string::npos);
    // Counts by what they mean, those that there are; their names are for programs.
    EXPECT_TRUE(whole["fallbacks"].contains("contrary") && whole["dropped"].contains("beside"));
    for (const char* name : {"fallbacks", "contrary", "beside", "  rank"})
        EXPECT_EQ(context.text.find(name), std::string::npos) << name << " in\n" << context.text;
    EXPECT_EQ(times_said("points left out"), 1u) << context.text;
    const auto n_smallest = whole["fallbacks"]["forced"].get<std::uint64_t>();
    EXPECT_EQ(times_said("of the smallest radius, with more error than asked"),
              n_smallest > 0 ? 1u : 0u)
        << context.text;
    const std::string levels = summary_text({{"levels", {{"10", 5}, {"2", 7}, {"1", 9}}}}, {});
    EXPECT_LT(levels.find("1   9"), levels.find("2   7")) << levels;
    EXPECT_LT(levels.find("2   7"), levels.find("10  5")) << levels;
}

TEST_F(BuildStage, GivesTheSameBytesForAnyNumberOfThreadsAndWhenResumed) {
    const std::string cloud = write(sampled("bumpy", 10000, 1, 1e-3), "bumpy.ply", false);
    for (const int slices : {1, 3}) {
        SCOPED_TRACE(slices);
        std::vector<std::string> models;
        for (const int n : {1, 2, 7}) {
            const ThreadLimit limit(n);
            auto config = build_config(cloud, "m" + std::to_string(n) + ".slim");
            config.slices = slices;
            config.work = file("work" + std::to_string(n));
            build(config);
            models.push_back(read_bytes(config.output));
            fs::remove(config.output);
            // As if killed in the last slice's fit: what follows is made again.
            fs::remove(fs::path(config.output + ".done.json"));
            const auto last = static_cast<std::size_t>(slices - 1);
            fs::remove(fit_path(config.work, last));
            const auto resumed = build(config);
            EXPECT_TRUE(resumed["stages"]["normals"].value("up_to_date", false));
            EXPECT_FALSE(resumed["stages"]["fit"].contains("up_to_date"));
            models.push_back(read_bytes(config.output));
        }
        for (const std::string& m : models) EXPECT_TRUE(m == models[0]);
    }
}

TEST_F(BuildStage, ManifestsOfItsStagesHoldTheHashesOfTheFilesAsTheyStand) {
    auto config = build_config(scanned_sphere(5000), "m.slim");
    config.slices = 2;
    config.work = file("work");
    build(config);
    std::size_t n_files = 0;
    for (const fs::path& output : {oriented_points_path(config.work, 1), fit_path(config.work, 1),
                                   coarse_fit_path(config.work)}) {
        const auto manifest = nlohmann::json::parse(read_bytes(manifest_path(output).string()));
        for (const auto& in : manifest.at("inputs")) {
            if (in.contains("absent")) continue;
            const auto path = in.at("path").get<std::string>();
            if (is_slice_file(path)) {
                EXPECT_EQ(in.at("identity"), slice_identity(path)) << in;
            } else {
                EXPECT_EQ(in.at("xxh3_128"), hash_file(path)) << in;
            }
            ++n_files;
        }
    }
    EXPECT_GE(n_files, 9u);
}

TEST_F(BuildStage, SlicesChangeTheResultWithinABound) {
    const std::string cloud = write(sampled("bumpy", 30000, 1, 3e-4), "bumpy.ply");
    double leaves[2] = {}, l2[2] = {}, normal[2] = {};
    for (const int slices : {1, 3}) {
        auto config = build_config(cloud, "m.slim");
        config.slices = slices;
        config.t_mdl = 0.002;  // so that most leaves are of fine levels, fitted slice by slice
        const auto result = build(config);
        const auto measured = measure(file("m.slim"), cloud);
        EXPECT_EQ(measured["missed"], 0);
        leaves[slices == 3] = result["leaves"].get<double>();
        l2[slices == 3] = measured["l2"].get<double>();
        normal[slices == 3] = measured["normal_rms_deg"].get<double>();
    }
    // Measured with 896 leaves: 1.002, 0.9998 and 1.0007.
    EXPECT_NEAR(leaves[1] / leaves[0], 1, 0.02);
    EXPECT_NEAR(l2[1] / l2[0], 1, 0.02);
    EXPECT_NEAR(normal[1] / normal[0], 1, 0.02);
}

TEST_F(BuildStage, AModelTakesTheOutputsPlaceOfModelsOnly) {
    const std::string cloud = write(sampled("sphere", 2000), "c.ply");
    const std::string other = write(sampled("sphere", 300), "other.ply");
    EXPECT_EQ(code_of([&] { build(build_config(cloud, "other.ply")); }), ExitCode::usage);
    EXPECT_NE(message_.find("other.ply: is there already and is a cloud"), std::string::npos)
        << message_;
    EXPECT_EQ(input_kind(other), InputKind::cloud);
    std::ofstream(file("notes.txt")) << "not a model";
    EXPECT_EQ(code_of([&] { build(build_config(cloud, "notes.txt")); }), ExitCode::usage);
    std::ofstream(file("empty.slim")).flush();
    std::ofstream(file("damaged.slim")) << "half a model";
    for (const char* name : {"empty.slim", "damaged.slim", "new.slim", "new.slim"})
        EXPECT_EQ(code_of([&] { build(build_config(cloud, name)); }), ExitCode::ok)
            << name << ": " << message_;
}

}  // namespace
}  // namespace slim::test
