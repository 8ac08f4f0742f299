#include "pipeline/build/fit_stage.h"

#include "formats/fit_file.h"
#include "pipeline/build/fit_noise.h"
#include "pipeline/build/fit_rules.h"
#include "pipeline/manifest.h"
#include "slim/base/hash.h"
#include "slim/model/surfel_tree.h"
#include "slim/slicing/block_plan.h"
#include "tests/pipeline/build/fit_stages_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

namespace slim::test {
namespace {

namespace fs = std::filesystem;

class FitStage : public FitStages {};

TEST(RulesJson, SaysThatLinesAreWiresWhereTheyAre) {
    CoverRules rules;
    EXPECT_FALSE(rules_json(rules).contains("lines_are_wires"));
    rules.lines_are_wires = true;
    EXPECT_EQ(rules_json(rules).value("lines_are_wires", false), true);
}

TEST_F(FitStage, MissingNormalsAreExit6AndNamed) {
    slice(write(sampled("sphere", 3000), "c.ply"), 3);
    EXPECT_EQ(code_of([&] { fit(); }), ExitCode::incomplete);
    EXPECT_NE(message_.find("slices 0 1 2"), std::string::npos) << message_;
    normals();
    fs::remove(fs::path(oriented_points_path(file("work"), 1).string() + ".done.json"));
    EXPECT_EQ(code_of([&] { fit(); }), ExitCode::incomplete);
    EXPECT_NE(message_.find("slices 1:"), std::string::npos) << message_;
}

TEST_F(FitStage, MissingSlicesAreExit6AndNamed) {
    slice(write(sampled("sphere", 3000), "c.ply"), 3);
    fs::remove(slice_points_path(file("work"), 1));
    EXPECT_EQ(code_of([&] { normals(); }), ExitCode::incomplete);
    EXPECT_NE(message_.find("slices are missing: 1:"), std::string::npos) << message_;
}

TEST_F(FitStage, NormalsOfDifferentOptionsAreExit6AndNamed) {
    slice(write(sampled("sphere", 3000), "c.ply"), 3);
    normals();
    NormalsConfig other;
    other.slice = 1;
    other.normals = "flip";
    normals(other);
    EXPECT_EQ(code_of([&] { fit(); }), ExitCode::incomplete);
    EXPECT_NE(message_.find("slices 0 2 with --normals auto"), std::string::npos) << message_;
    EXPECT_NE(message_.find("slice 1 with --normals flip"), std::string::npos) << message_;
    EXPECT_EQ(message_.find("neighbors"), std::string::npos) << message_;
    other.slice = -1;
    normals(other);
    EXPECT_EQ(code_of([&] { fit(); }), ExitCode::ok) << message_;
}

TEST_F(FitStage, NormalsOfAnotherVersionAreNamed) {
    slice(write(sampled("sphere", 2000), "c.ply"), 1);
    normals();
    const auto path = manifest_path(oriented_points_path(file("work"), 0));
    std::ifstream in(path);
    auto manifest = nlohmann::json::parse(in);
    for (auto& one : manifest["result"]["noise"]) one.erase("bins");
    std::ofstream(path) << manifest.dump();
    EXPECT_EQ(code_of([&] { fit(); }), ExitCode::bad_data);
    EXPECT_NE(message_.find("no manifest of this version"), std::string::npos) << message_;
}

TEST_F(FitStage, WritesSurfelsAndCounts) {
    slice(write(sampled("sphere", 10000), "c.ply"), 1);
    normals();
    const auto r = fit();
    const FitFile file_read = read_fit(fit_path(file("work"), 0).string());
    std::size_t leaves = 0;
    for (const FittedSurfel& s : file_read.surfels) leaves += (s.flags & kLeaf) != 0;
    EXPECT_EQ(r["leaves"], leaves);
    EXPECT_EQ(r["leaves"].get<std::size_t>() + r["internals"].get<std::size_t>(),
              file_read.surfels.size());
    EXPECT_FALSE(fs::exists(coarse_fit_path(file("work"))));
    EXPECT_TRUE(fit().value("up_to_date", false));
}

TEST_F(FitStage, LambdaIsMeasuredFlooredOrGiven) {
    slice(write(sampled("sphere", 5000), "c.ply"), 1);
    normals();
    FitConfig config;
    config.work = file("work");
    const SlicePlan plan = read_plan(config.work);
    const GlobalNoise measured = read_global_noise(config.work, config.lambda, plan);
    EXPECT_GT(measured.noise_variance, 1e-10);
    EXPECT_FALSE(measured.floored);
    config.lambda = 1e-3;
    EXPECT_EQ(read_global_noise(config.work, config.lambda, plan).noise_variance, 1e-3);
    slice(write(sampled("plane", 5000), "flat.ply"), 1);
    normals();
    config.lambda = 0;
    const GlobalNoise flat = read_global_noise(config.work, config.lambda, read_plan(config.work));
    EXPECT_TRUE(flat.floored);
    EXPECT_GT(flat.noise_variance, 0);
}

TEST_F(FitStage, NoiseThatSmoothingTookOffCountsByPointsAndLeavesNormalsThatEndNothing) {
    slice(write(sampled("sphere", 5000), "c.ply"), 1);
    normals();
    SlicePlan plan = read_plan(file("work"));
    const GlobalNoise clean = read_global_noise(file("work"), 0, plan);
    EXPECT_EQ(clean.contrary_share, 0);
    const auto with = [&](double variance) {
        plan.inputs[0].noise_variance = variance;
        write_plan(file("work"), plan);
        return read_global_noise(file("work"), 0, read_plan(file("work")));
    };
    const GlobalNoise smoothed = with(10 * clean.noise_variance);
    EXPECT_EQ(smoothed.noise_variance, 10 * clean.noise_variance);
    EXPECT_EQ(smoothed.mean_variance, 10 * clean.noise_variance);
    EXPECT_EQ(smoothed.typical_variance, 10 * clean.noise_variance);
    EXPECT_GT(smoothed.contrary_share, 0.001);
    EXPECT_EQ(read_global_noise(file("work"), 1e-9, plan).noise_variance, 1e-9);
    // As a clean cloud's is after smoothing: it was no noise.
    EXPECT_EQ(with(1.5 * clean.noise_variance).contrary_share, 0);
    EXPECT_EQ(with(0.5 * clean.noise_variance).noise_variance, clean.noise_variance);
    // Beside three times as many points of another scan.
    PlanInput other = plan.inputs[0];
    other.n_points = 15000, other.noise_variance = 0;
    plan.inputs.push_back(other);
    EXPECT_DOUBLE_EQ(smoothed_variance(plan), 0.125 * clean.noise_variance);
}

TEST_F(FitStage, StraysLeaveLambdaAsItIsInAnyNumberOfSlices) {
    Cloud cloud = sampled("bumpy", 30000, 1, 2e-4);
    const auto measured = [&](int n_slices) {
        slice(write(cloud, "c.ply"), n_slices);
        normals();
        return read_global_noise(file("work"), 0, read_plan(file("work")));
    };
    const double clean = measured(1).noise_variance;
    EXPECT_EQ(measured(1).mean_variance, clean);
    EXPECT_NEAR(measured(3).noise_variance, clean, 1e-12 * clean);
    const auto random = [](std::uint64_t n) { return 3 * unit_interval(keyed_hash(8, n)) - 1.5; };
    for (std::uint64_t i = 0; i < 300; ++i)
        cloud.positions[100 * i] = {random(3 * i), random(3 * i + 1), random(3 * i + 2)};
    const GlobalNoise soiled = measured(1);
    EXPECT_GT(soiled.mean_variance, 10 * clean);
    EXPECT_LT(soiled.noise_variance, 2 * clean);
    // Some strays' neighbours lie beyond the slices' surroundings.
    EXPECT_NEAR(measured(3).noise_variance, soiled.noise_variance, 0.02 * clean);
}

TEST_F(FitStage, WhereStraysOrNoisyPartsMakeTheMeanLeavesAreNotFittedAgain) {
    SlicePlan plan;
    plan.diagonal = 1;
    GlobalNoise noise;
    noise.spacing = 0.01;
    noise.noise_variance = noise.mean_variance = 25e-8;  // 0.05 spacings
    EXPECT_TRUE(fit_rules({}, 1, plan, noise).refits);
    noise.mean_variance = 9e-6;
    EXPECT_FALSE(fit_rules({}, 1, plan, noise).refits);
}

TEST_F(FitStage, GivenNormalsAreFollowedWhereTheyTellMoreThanNoisyPoints) {
    const auto follows = [&](double noise, const NormalsConfig& normals_config,
                             const FitConfig& config) {
        slice(write(sampled("bumpy", 20000, 1, noise), "c.ply"), 2);
        normals(normals_config);
        return fit(config)["follow_normals"].get<bool>();
    };
    NormalsConfig estimated;
    estimated.normals = "estimate";
    FitConfig windows;
    windows.radius_rule = "windows";
    EXPECT_TRUE(follows(3e-3, {}, {}));
    EXPECT_FALSE(follows(0, {}, {}));
    EXPECT_FALSE(follows(3e-3, estimated, {}));
    EXPECT_FALSE(follows(3e-3, {}, windows));
}

TEST_F(FitStage, LeavesAreFittedAgainBetweenSmoothAndNoisy) {
    const auto refitted = [&](const Cloud& cloud, const FitConfig& config) {
        slice(write(cloud, "c.ply"), 1);
        NormalsConfig estimated;  // they are not followed then
        estimated.normals = "estimate";
        normals(estimated);
        return fit(config)["refitted"].get<std::uint64_t>();
    };
    FitConfig windows, polynomial;
    windows.radius_rule = "windows", polynomial.weight = "polynomial";
    const Cloud rough = sampled("torus", 5000);  // sqrt(lambda) is 0.06 of the spacing
    EXPECT_GT(refitted(rough, {}), 100u);
    EXPECT_EQ(refitted(rough, windows), 0u);
    EXPECT_EQ(refitted(rough, polynomial), 0u);
    EXPECT_EQ(refitted(sampled("torus", 40000), {}), 0u) << "smooth";
    EXPECT_EQ(refitted(sampled("torus", 5000, 1, 3e-3), {}), 0u) << "noisy";
}

// Coarse levels are fitted once, before all leaves are known.
TEST_F(FitStage, SlicesHardlyChangeLeavesThatAreFittedAgain) {
    const std::string cloud = write(sampled("sculpture", 100000), "c.ply");
    std::vector<double> leaves, l2;
    for (const int slices : {1, 3}) {
        slice(cloud, slices);
        normals();
        const auto r = fit();
        EXPECT_GT(r["refitted"].get<double>(), 0.5 * r["leaves"].get<double>());
        leaves.push_back(r["leaves"]);
        tree("m.slim");
        l2.push_back(measure(file("m.slim"), cloud)["l2"]);
    }
    EXPECT_NEAR(leaves[1] / leaves[0], 1, 0.01);
    EXPECT_NEAR(l2[1] / l2[0], 1, 0.02);
}

TEST_F(FitStage, EdgesOfACleanCloudAreNoNoise) {
    // A cube of exact points and normals: lambda comes from its edges.
    Cloud cube;
    for (std::uint64_t i = 0; i < 6000; ++i) {
        Vec3d p, n;
        for (std::size_t k = 0; k < 3; ++k) p[k] = 2 * unit_interval(keyed_hash(k, i)) - 1;
        n[i % 3] = p[i % 3] = i % 2 == 0 ? 1.0 : -1.0;
        cube.positions.push_back(p);
        cube.normals.push_back(to_float(n));
        cube.truth.push_back({});
        cube.scan_ids.push_back(0);
    }
    slice(write(cube, "cube.ply"), 1);
    normals();
    EXPECT_FALSE(fit()["follow_normals"].get<bool>());
}

TEST_F(FitStage, SlicesOwnTheCentresOfTheirRegionAndCoarseLevelsAreShared) {
    slice(write(sampled("bumpy", 20000), "c.ply"), 3);
    normals();
    FitConfig config;
    config.t_mdl = 0.003;
    fit(config);
    const SlicePlan plan = read_plan(file("work"));
    ASSERT_EQ(plan.slices.size(), 3u);
    int first_fine = 48;
    for (std::size_t i = 0; i < 3; ++i)
        for (const FittedSurfel& s : read_fit(fit_path(file("work"), i).string()).surfels) {
            EXPECT_TRUE(is_in(plan.slices[i].region, s.surfel.center));
            first_fine = std::min<int>(first_fine, s.level);
        }
    for (const FittedSurfel& s : read_fit(coarse_fit_path(file("work")).string()).surfels)
        EXPECT_LT(s.level, first_fine);
}

TEST_F(FitStage, SlicesMayBeFittedOneByOneInAnyOrder) {
    slice(write(sampled("bumpy", 10000), "c.ply"), 3);
    normals();
    fit();
    std::vector<std::string> together;
    for (std::size_t i = 0; i < 3; ++i)
        together.push_back(read_bytes(fit_path(file("work"), i).string()));
    for (std::size_t i = 0; i < 3; ++i) fs::remove(fit_path(file("work"), i));
    fs::remove(coarse_fit_path(file("work")));
    FitConfig config;
    for (const int i : {2, 0, 1}) {
        config.slice = i;
        fit(config);
    }
    for (std::size_t i = 0; i < 3; ++i)
        EXPECT_TRUE(read_bytes(fit_path(file("work"), i).string()) == together[i]);
    config.slice = kAllSlices;
    EXPECT_TRUE(fit(config).contains("up_to_date"))
        << "which slice was asked for is no setting of the fit";
}

TEST_F(FitStage, SlicesHardlyChangeWhatComesOut) {
    const std::string cloud = write(sampled("bumpy", 60000, 1, 1e-3), "c.ply");
    std::vector<double> leaves, lambda;
    for (const int slices : {1, 2, 5}) {
        slice(cloud, slices);
        normals();
        FitConfig config;
        config.t_mdl = 0.003;
        const auto r = fit(config);
        leaves.push_back(r["leaves"]);
        lambda.push_back(r["noise_variance"]);
    }
    ASSERT_GT(leaves[0], 300);
    for (std::size_t i = 1; i < leaves.size(); ++i) {
        SCOPED_TRACE(i);
        // Neighbours beyond a cut count like others; which points serve for large k depends on the
        // slice.
        EXPECT_NEAR(lambda[i] / lambda[0], 1, 1e-3);
        EXPECT_NEAR(leaves[i] / leaves[0], 1, 0.01);
    }
}

TEST_F(FitStage, ASampleOfTheMemorysSizeNeverCostsAccuracy) {
    const std::string cloud = write(sampled("bumpy", 60000, 1, 1e-3), "c.ply");
    slice(cloud, 3);
    normals();
    FitConfig config;
    config.t_mdl = 0.003;
    const auto all = fit(config);
    config.memory = "20MiB";
    const auto r = fit(config);
    EXPECT_LT(r["sample"], 30000);
    EXPECT_EQ(all["sample"], 60000);
    // What it does not resolve is covered by more leaves, no wider than the halo, not by fewer.
    EXPECT_GT(r["leaves"].get<double>(), 0.99 * all["leaves"].get<double>());
    EXPECT_LT(r["leaves"].get<double>(), 1.7 * all["leaves"].get<double>());
}

TEST_F(FitStage, LittleMemoryLosesNoPointsAndMakesNoInternalSurfelsForNobody) {
    // Half of the sculpture's points lie on a flat base: slabs across one axis were thinner than a
    // few spacings, so was their halo, and what the sample does not resolve became internal
    // surfels.
    const std::string cloud = write(sampled("sculpture", 60000), "c.ply");
    slice(cloud, 1);
    normals();
    const auto whole = fit();
    slice(cloud, 0, "19MiB");
    ASSERT_GE(read_plan(file("work")).slices.size(), 6u);
    normals();
    FitConfig config;
    config.memory = "19MiB";
    const auto r = fit(config);
    EXPECT_LT(r["dropped_isolated"].get<double>(), whole["dropped_isolated"].get<double>() + 20);
    EXPECT_NEAR(r["leaves"].get<double>() / whole["leaves"].get<double>(), 1, 0.03);
    EXPECT_LT(r["internals"].get<double>(), 2 * whole["internals"].get<double>());
}

TEST_F(FitStage, CoarseLevelsMayBeFittedAlone) {
    slice(write(sampled("bumpy", 10000), "c.ply"), 2);
    normals();
    FitConfig config;
    config.coarse = true;
    const auto coarse = fit(config);
    EXPECT_GT(coarse.at("sample"), 0);
    EXPECT_TRUE(fs::exists(coarse_fit_path(file("work"))));
    EXPECT_FALSE(fs::exists(fit_path(file("work"), 0)));
    EXPECT_TRUE(fit(config).contains("up_to_date"));
    config.coarse = false;
    config.slice = 1;
    const auto time = fs::last_write_time(manifest_path(coarse_fit_path(file("work"))));
    fit(config);
    EXPECT_EQ(fs::last_write_time(manifest_path(coarse_fit_path(file("work")))), time)
        << "fitted again";
}

}  // namespace
}  // namespace slim::test
