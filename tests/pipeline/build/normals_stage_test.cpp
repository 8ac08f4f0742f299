#include "tests/pipeline/build/normals_stage_support.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <tuple>

namespace slim::test {
namespace {

TEST_F(NormalsStage, KeepsGoodNormals) {
    slice(write(sampled("sphere", 10000), "c.ply"), 1);
    const auto r = normals();
    EXPECT_EQ(r["kept"], 10000);
    EXPECT_EQ(r["estimated"], 0);
    EXPECT_EQ(r["turned"], 0);
    EXPECT_TRUE(listener_.warnings.empty());
    EXPECT_TRUE(normals().value("up_to_date", false));
}

TEST_F(NormalsStage, TurnsAFewAndEstimatesAllWhereManyAreWrong) {
    slice(write(with_flips(0.05), "c.ply"), 1);
    const auto few = normals();
    EXPECT_NEAR(few["turned"].get<double>(), 500, 60);
    EXPECT_EQ(few["estimated"], 0);
    EXPECT_TRUE(listener_.warnings.empty());
    EXPECT_LT(inwards(oriented()), 30u);

    for (const double share : {0.2, 0.3, 0.4, 0.5, 0.6, 0.7}) {
        SCOPED_TRACE(share);
        listener_.warnings.clear();
        slice(write(with_flips(share), "d.ply"), 1);
        const auto many = normals();
        EXPECT_EQ(many["estimated"], 10000);
        EXPECT_EQ(many["turned"], 0);
        ASSERT_EQ(listener_.warnings.size(), 1u);
        EXPECT_NE(listener_.warnings[0].find("estimated anew"), std::string::npos);
        EXPECT_EQ(inwards(oriented()), 0u);  // whatever the given ones say
        const bool in_doubt = listener_.warnings[0].find("in doubt") != std::string::npos;
        EXPECT_TRUE(in_doubt || share < 0.25);
    }
}

TEST_F(NormalsStage, NormalsThatAreMostlyRightSayWhichSideIsOut) {
    // A bowl seen from inside, a third of it flipped: the rule of flux would turn all of it
    // outwards.
    const Cloud cloud = sampled("sphere", 20000);
    Cloud bowl;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        if (cloud.positions[i].z > 0) continue;
        const bool flipped = unit_interval(keyed_hash(3, i)) < 0.3;
        bowl.positions.push_back(cloud.positions[i]);
        bowl.normals.push_back(flipped ? cloud.normals[i] : -cloud.normals[i]);
        bowl.scan_ids.push_back(0);
    }
    slice(write(bowl, "c.ply"), 1);
    EXPECT_EQ(normals()["estimated"], bowl.size());
    EXPECT_EQ(inwards(oriented()), bowl.size());
}

TEST_F(NormalsStage, KeepTakesThemAsTheyAre) {
    const Cloud cloud = with_flips(0.3);
    slice(write(cloud, "c.ply"), 1);
    NormalsConfig config;
    config.normals = "keep";
    const auto r = normals(config);
    EXPECT_EQ(r["kept"], 10000);
    const PointBlock block = oriented();
    for (std::size_t i = 0; i < block.size(); ++i)
        ASSERT_GT(dot(block.normal[i], cloud.normals[block.id[i]]), 0.999f);
}

TEST_F(NormalsStage, KeepGivesNoneToACloudWithoutInSlicesEither) {
    slice(write(sampled("torus", 10000), "c.ply", false), 3);
    NormalsConfig config;
    config.normals = "keep";
    EXPECT_EQ(normals(config)["estimated"], 0);
    for (std::size_t i = 0; i < 3; ++i) {
        const PointBlock block = oriented(i);
        EXPECT_GT(block.size(), 0u);
        for (const Vec3f& n : block.normal) ASSERT_EQ(n, Vec3f{});
    }
}

TEST_F(NormalsStage, EstimatesMissingNormalsAndOnRequestAll) {
    const Cloud cloud = sampled("torus", 10000);
    slice(write(cloud, "c.ply", false), 1);
    const auto r = normals();
    EXPECT_EQ(r["estimated"], 10000);
    const PointBlock block = oriented();
    for (std::size_t i = 0; i < block.size(); ++i)
        ASSERT_GT(dot(block.normal[i], cloud.normals[block.id[i]]), 0.5f);
    slice(write(cloud, "d.ply"), 1);
    NormalsConfig config;
    config.normals = "estimate";
    EXPECT_EQ(normals(config)["estimated"], 10000);
}

TEST_F(NormalsStage, SlicesOfOneObjectAgreeOnItsOutside) {
    const Cloud cloud = sampled("sphere", 20000);
    slice(write(cloud, "c.ply", false), 8);
    EXPECT_EQ(normals()["estimated"], 20000);
    const SlicePlan plan = read_plan(file("work"));
    ASSERT_GE(plan.slices.size(), 6u);
    for (std::size_t i = 0; i < plan.slices.size(); ++i) {
        const PointBlock block = read_slice(oriented_points_path(file("work"), i).string());
        EXPECT_EQ(block.size(), plan.slices[i].n_points);
        for (std::size_t k = 0; k < block.size(); ++k)
            ASSERT_GT(dot(block.normal[k], cloud.normals[block.id[k]]), 0.5f) << "slice " << i;
    }
}

// Cuts go through some of the spheres; those beside them lie far from the middle of the cloud.
TEST_F(NormalsStage, SeparateObjectsFaceOutwardsInAnyNumberOfSlices) {
    Cloud spheres;
    for (std::size_t k = 0; k < 12; ++k) {
        const Cloud one = sampled("sphere", 2000, 1 + k);
        const Vec3d center{3.0 * static_cast<double>(k % 4), 3.0 * static_cast<double>(k / 4), 0};
        for (const Vec3d& p : one.positions) spheres.positions.push_back(p + center);
        spheres.normals.insert(spheres.normals.end(), one.normals.begin(), one.normals.end());
    }
    spheres.scan_ids.assign(spheres.positions.size(), 0);
    for (const int n : {1, 3, 7}) {
        SCOPED_TRACE(n);
        slice(write(spheres, fmt::format("c{}.ply", n), false), n);
        EXPECT_EQ(normals()["estimated"], spheres.size());
        for (std::size_t i = 0; i < read_plan(file("work")).slices.size(); ++i) {
            const PointBlock block = oriented(i);
            for (std::size_t k = 0; k < block.size(); ++k)
                ASSERT_GT(dot(block.normal[k], spheres.normals[block.id[k]]), 0.5f) << i;
        }
        EXPECT_TRUE(normals().value("up_to_date", false));
    }
}

TEST_F(NormalsStage, TakesMoreNeighboursWhereNoiseIsThick) {
    for (const auto& [noise, least, most] :
         {std::tuple{0.0, 16, 16}, {0.001, 16, 16}, {0.02, 40, 64}}) {
        SCOPED_TRACE(noise);
        slice(write(sampled("sphere", 50000, 1, noise), fmt::format("c{}.ply", noise), false), 1);
        const int n = normals()["neighbors"];
        EXPECT_GE(n, least);
        EXPECT_LE(n, most);
    }
    NormalsConfig config;
    config.neighbors = 24;
    slice(write(sampled("sphere", 5000), "few.ply", false), 1);
    EXPECT_EQ(normals(config)["neighbors"], 24);
    config.neighbors = 3;
    EXPECT_THROW(normals(config), ConfigError);
}

TEST_F(NormalsStage, SlicesInThickNoiseTakeMoreNeighboursAsTheWholeDoes) {
    const Cloud cloud = sampled("sphere", 60000, 1, 0.02);
    const std::string path = write(cloud, "c.ply", false);
    struct Found {
        double widened = 0, mean_angle_deg = 0;
        std::size_t n_inwards = 0;
        int neighbors = 0;
    };
    const auto found_in = [&](int slices, int neighbors) {
        slice(path, slices, "64MiB");
        NormalsConfig config;
        config.neighbors = neighbors;
        const auto r = normals(config);
        EXPECT_EQ(r["slices"], slices);
        Found found{r["estimates_widened"].get<double>(), 0, 0, r["neighbors"].get<int>()};
        for (int i = 0; i < slices; ++i) {
            const PointBlock block = oriented(static_cast<std::size_t>(i));
            for (std::size_t k = 0; k < block.size(); ++k) {
                const double c = dot(to_double(block.normal[k]), cloud.truth[block.id[k]].normal);
                found.n_inwards += c < 0;
                found.mean_angle_deg += std::acos(std::clamp(std::abs(c), 0.0, 1.0)) * 180 /
                                        std::numbers::pi / static_cast<double>(cloud.size());
            }
        }
        return found;
    };
    const Found whole = found_in(1, 0), few = found_in(4, 16);
    EXPECT_GT(whole.widened, 50000);
    EXPECT_EQ(few.widened, 0);
    for (const int slices : {2, 4}) {
        SCOPED_TRACE(slices);
        const Found found = found_in(slices, 0);
        EXPECT_EQ(found.neighbors, whole.neighbors);
        EXPECT_NEAR(found.widened, whole.widened, 0.01 * whole.widened);
        EXPECT_NEAR(found.mean_angle_deg, whole.mean_angle_deg, 0.2);
        EXPECT_LT(found.mean_angle_deg, 0.7 * few.mean_angle_deg);
        EXPECT_LT(found.n_inwards, 20u);
    }
}

// What is estimated is looked at once more, not the normals that the cloud has.
TEST_F(NormalsStage, AMissingNormalChangesNoOther) {
    Cloud cloud = with_flips(0.06);
    slice(write(cloud, "c.ply"), 1);
    const auto all = normals();
    const PointBlock before = oriented();
    cloud.normals[5000] = {};
    slice(write(cloud, "d.ply"), 1);
    const auto missing = normals();
    EXPECT_EQ(missing["estimated"], 1);
    EXPECT_EQ(missing["neighbors"], 16);
    const PointBlock after = oriented();
    std::size_t n_other = 0;
    for (std::size_t i = 0; i < before.size(); ++i)
        n_other += before.id[i] != 5000 && !(before.normal[i] == after.normal[i]);
    EXPECT_LE(n_other, 16u);  // whose majority it was part of
}

TEST_F(NormalsStage, WorksSliceBySlice) {
    slice(write(sampled("sphere", 10000), "c.ply"), 3);
    NormalsConfig config;
    config.slice = 1;
    EXPECT_EQ(normals(config)["slices"], 1);
    EXPECT_FALSE(std::filesystem::exists(oriented_points_path(file("work"), 0)));
    EXPECT_TRUE(std::filesystem::exists(oriented_points_path(file("work"), 1)));
    config.slice = 3;
    EXPECT_EQ(code_of([&] { normals(config); }), ExitCode::usage);
    ::setenv("SLURM_ARRAY_TASK_ID", "2", 1);
    const auto r = normals();
    ::unsetenv("SLURM_ARRAY_TASK_ID");
    EXPECT_EQ(r["slices"], 1);
    EXPECT_TRUE(std::filesystem::exists(oriented_points_path(file("work"), 2)));
    EXPECT_EQ(normals()["slices"], 3);
}

TEST_F(NormalsStage, KeepsNormalsWithoutOptionsOfTheirEstimate) {
    slice(write(sampled("sphere", 500), "c.ply"), 1);
    NormalsConfig config;
    config.normals = "keep";
    config.neighbors = 5;
    EXPECT_EQ(code_of([&] { normals(config); }), ExitCode::usage);
    config.neighbors = 0, config.sensors = file("c.scans.json");
    EXPECT_EQ(code_of([&] { normals(config); }), ExitCode::usage);
    config.sensors.clear();
    EXPECT_EQ(code_of([&] { normals(config); }), ExitCode::ok);
}

}  // namespace
}  // namespace slim::test
