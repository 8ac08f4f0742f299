#include "pipeline/build/normals_stage.h"

#include "formats/slice_file.h"
#include "slim/base/hash.h"
#include "tests/pipeline/build/fit_stages_support.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <tuple>

namespace slim::test {
namespace {

class NormalsStage : public FitStages {
protected:
    PointBlock oriented(std::size_t slice = 0) {
        return read_slice(oriented_points_path(file("work"), slice).string());
    }
    Cloud with_flips(double share) {
        Cloud cloud = sampled("sphere", 10000);
        for (std::size_t i = 0; i < cloud.size(); ++i)
            if (unit_interval(keyed_hash(1, i)) < share) cloud.normals[i] = -cloud.normals[i];
        return cloud;
    }
    static std::size_t inwards(const PointBlock& block) {
        std::size_t n = 0;
        for (std::size_t i = 0; i < block.size(); ++i)
            n += dot(to_double(block.normal[i]), block.position[i] + block.origin) < 0;
        return n;
    }
};

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

TEST_F(NormalsStage, TakesDirectionsOfScannersThatAreFar) {
    // Seen along -x, a sphere's normals all point to -x, also at the back.
    const std::string path = write(sampled("sphere", 5000), "c.ply", false);
    folder_.write("c.scans.json", R"({"scans": [{"id": 0, "direction": [-2, 0, 0]}]})");
    slice(path, 1);
    EXPECT_EQ(normals()["oriented_by_sensor"], 5000);
    std::size_t towards = 0;
    for (const Vec3f& n : oriented().normal) towards += n.x <= 1e-3f;
    EXPECT_EQ(towards, 5000u);
}

TEST_F(NormalsStage, UsesTheSensorsBesideTheCloud) {
    // A scanner in the middle of the sphere sees it from inside.
    Cloud cloud = sampled("sphere", 5000);
    const std::string path = write(cloud, "c.ply", false);
    folder_.write("c.scans.json", R"({"scans": [{"id": 0, "position": [0, 0, 0]}]})");
    slice(path, 1);
    const auto r = normals();
    EXPECT_EQ(r["oriented_by_sensor"], 5000);
    EXPECT_EQ(inwards(oriented()), 5000u);
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

// Noise as large as the spacing tilts estimates by 15 degrees and more: where a scanner looks along
// the surface it gives them the wrong sign.
TEST_F(NormalsStage, SignsThatASensorGetsWrongAreTurnedByTheNeighbours) {
    const Cloud cloud = sampled("sphere", 20000, 1, 5e-3);
    const std::string path = write(cloud, "c.ply", false);
    // From inside, near the surface: nothing is seen at more than 82 degrees.
    folder_.write("c.scans.json", R"({"scans": [{"id": 0, "position": [0, 0, 0.99]}]})");
    slice(path, 1);
    const auto r = normals();
    EXPECT_EQ(r["oriented_by_sensor"], 20000);
    EXPECT_EQ(r["turned"], 0);  // that is of a cloud's own
    const std::size_t turned = r["estimates_turned"], outwards = 20000 - inwards(oriented());
    EXPECT_GT(turned, 200u);
    EXPECT_LT(2 * outwards, turned);
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

/// An environment variable while it lives.
class Variable {
public:
    Variable(const char* name, const char* value) : name_(name) { ::setenv(name, value, 1); }
    ~Variable() { ::unsetenv(name_); }

private:
    const char* name_;
};

SlicePlan plan_of(std::size_t n) {
    SlicePlan plan;
    plan.slices.resize(n);
    return plan;
}

std::vector<std::size_t> slices(std::size_t n, int slice, int per_task) {
    SliceChoice choice;
    choice.slice = slice, choice.slices_per_task = per_task;
    return slices_to_do(choice, plan_of(n));
}

std::string refusal(std::size_t n, int slice, int per_task) {
    try {
        slices(n, slice, per_task);
        return "";
    } catch (const ConfigError& error) {
        return error.what();
    }
}

using Numbers = std::vector<std::size_t>;

TEST(SlicesToDo, ATaskOfAnArrayDoesItsOwn) {
    EXPECT_EQ(slices(3, -1, 1), (Numbers{0, 1, 2}));
    EXPECT_EQ(slices(3, 1, 1), (Numbers{1}));
    {
        const Variable task("PBS_ARRAY_INDEX", "1");
        EXPECT_EQ(slices(10, -1, 1), (Numbers{1}));
        EXPECT_EQ(slices(10, -1, 4), (Numbers{4, 5, 6, 7}));
        EXPECT_EQ(slices(10, kAllSlices, 1).size(), 10u);
        EXPECT_EQ(slices(10, 7, 1), (Numbers{7}));
    }
    const Variable task("SGE_TASK_ID", "3");  // from 1
    EXPECT_EQ(slices(10, -1, 4), (Numbers{8, 9}));
}

TEST(SlicesToDo, TasksTogetherDoAllOnce) {
    Numbers all;
    for (const char* index : {"0", "1", "2", "3"}) {
        const Variable task("SLURM_ARRAY_TASK_ID", index);
        const Numbers own = slices(11, -1, 3);
        all.insert(all.end(), own.begin(), own.end());
    }
    EXPECT_EQ(all, (Numbers{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10}));
    const Variable task("SLURM_ARRAY_TASK_ID", "4");
    EXPECT_EQ(
        refusal(11, -1, 3),
        "task 4: at 3 slices a task the slices 0 to 10 of the plan are those of tasks 0 to 3");
}

TEST(SlicesToDo, AnIndexThatIsNoneIsRefusedByItsVariable) {
    for (const char* index : {"0abc", "abc", "-1", "1.5", " 1", "99999999999999999999"}) {
        const Variable task("PBS_ARRAY_INDEX", index);
        EXPECT_NE(refusal(3, -1, 1).find(std::string("PBS_ARRAY_INDEX=") + index + ":"),
                  std::string::npos)
            << index;
    }
    const Variable first("SGE_TASK_ID", "0");
    EXPECT_NE(refusal(3, -1, 1).find("SGE_TASK_ID=0"), std::string::npos);
    const Variable none("SGE_TASK_ID", "undefined");  // what SGE says outside of arrays
    EXPECT_EQ(slices(3, -1, 1).size(), 3u);
}

TEST(SlicesToDo, SlicesPerTaskIsForArrays) {
    EXPECT_NE(refusal(3, -1, 2).find("SLURM_ARRAY_TASK_ID"), std::string::npos);
    EXPECT_NE(refusal(3, 1, 2).find("leave out one"), std::string::npos);
}

TEST_F(NormalsStage, SensorsThatAreNoneAreRefusedByScanAndFile) {
    const std::string path = write(sampled("sphere", 500), "c.ply", false);
    const auto refused = [&](const std::string& entry) -> std::string {
        folder_.write("c.scans.json", "{\"scans\": [" + entry + "]}");
        slice(path, 1);
        try {
            normals();
            return "";
        } catch (const FormatError& error) {
            return error.what();
        }
    };
    for (const auto& [entry, told] :
         {std::pair{R"({"id": 0, "direction": [0, 0, 0]})", "scan 0: direction [0,0,0]"},
          std::pair{R"({"id": 4294967296, "position": [0, 0, 9]})", "scan 4294967296:"},
          std::pair{R"({"id": 65536, "position": [0, 0, 9]})", "scan 65536:"},
          std::pair{R"({"id": -1, "position": [0, 0, 9]})", "scan -1:"},
          std::pair{R"({"id": 0.5, "position": [0, 0, 9]})", "scan 0.5:"},
          std::pair{R"({"id": 0, "position": [0, 9]})", "scan 0: position [0,9]"},
          std::pair{R"({"id": 0, "position": [0, null, 9]})", "c.scans.json"},
          std::pair{R"({"id": 0, "position": [0, 1e999, 9]})", "c.scans.json"}}) {
        const std::string message = refused(entry);
        EXPECT_NE(message.find(told), std::string::npos) << entry << ": " << message;
        EXPECT_NE(message.find("c.scans.json"), std::string::npos) << message;
    }
    EXPECT_EQ(refused(R"({"id": 0, "direction": [0, 0, 1e-200]})"), "");
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
