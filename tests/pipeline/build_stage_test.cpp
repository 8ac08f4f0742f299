#include "pipeline/build_stage.h"

#include "formats/model_file.h"
#include "formats/slice_file.h"
#include "pipeline/info_stage.h"
#include "pipeline/input_kind.h"
#include "pipeline/manifest.h"
#include "pipeline/scan_stage.h"
#include "pipeline/smooth_stage.h"
#include "slim/base/parallel.h"
#include "tests/pipeline/fit_stages_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace slim::test {
namespace {

namespace fs = std::filesystem;

class BuildStage : public FitStages {
protected:
    std::string scanned_sphere(std::uint64_t n) {
        ScanSettings s;
        s.n_points = n;
        s.n_stations = 6;
        return write(scanned("sphere", s), "sphere.ply");
    }
};

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

TEST_F(BuildStage, CloudsOfOtherFramesAreWarnedOfWithBothBoxes) {
    Cloud far = sampled("sphere", 500);
    BuildConfig c = build_config(write(far, "here.ply"), "m.slim");
    for (Vec3d& p : far.positions) p += Vec3d{3, 0, 0};
    c.inputs.push_back(write(far, "beside.ply"));
    build(c);
    EXPECT_TRUE(listener_.warnings.empty()) << listener_.warnings[0];
    for (Vec3d& p : far.positions) p += Vec3d{403000, 3604900, 0};
    c.inputs.push_back(write(far, "georeferenced.ply"));
    build(c);
    ASSERT_FALSE(listener_.warnings.empty());
    const std::string& said = listener_.warnings[0];
    for (const char* part : {"georeferenced.ply", "here.ply", "(403002", "(-0.99", "same frame?"})
        EXPECT_NE(said.find(part), std::string::npos) << part << " in " << said;
}

TEST_F(BuildStage, TilesInARowAreOfOneFrame) {
    Cloud tile = sampled("sphere", 300);
    BuildConfig c = build_config(write(tile, "tile_0.ply"), "m.slim");
    for (int i = 1; i < 20; ++i) {
        for (Vec3d& p : tile.positions) p += Vec3d{2, 0, 0};
        c.inputs.push_back(write(tile, "tile_" + std::to_string(i) + ".ply"));
    }
    build(c);
    for (const std::string& said : listener_.warnings)
        EXPECT_EQ(said.find("same frame?"), std::string::npos) << said;
}

TEST_F(BuildStage, CloudsOfOtherFramesDoNotHideWhatElseIsWrong) {
    BuildConfig c =
        build_config(folder_.write("line.xyz", "0 0 0\n1 0 0\n2 0 0\n3 0 0\n"), "m.slim");
    c.inputs.push_back(folder_.write("far.xyz", "1e6 0 0\n1000001 0 0\n"));
    code_of([&] { build(c); });
    ASSERT_GE(listener_.warnings.size(), 2u);
    EXPECT_NE(listener_.warnings[0].find("same frame?"), std::string::npos)
        << listener_.warnings[0];
    EXPECT_NE(listener_.warnings[1].find("on one line"), std::string::npos)
        << listener_.warnings[1];
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
    for (const char* key : {"diagonal", "degree", "t_mdl", "forced"})
        EXPECT_EQ(times_said(key), 1u) << key << " in\n" << context.text;
    EXPECT_EQ(times_said("noise_variance"), 0u) << context.text;  // noise says it, over L
    EXPECT_NE(context.text.find("noise "), std::string::npos);
    const std::string levels = summary_text({{"levels", {{"10", 5}, {"2", 7}, {"1", 9}}}}, {});
    EXPECT_LT(levels.find("1   9"), levels.find("2   7")) << levels;
    EXPECT_LT(levels.find("2   7"), levels.find("10  5")) << levels;
}

TEST_F(BuildStage, KeptNormalsTakeNoSensors) {
    BuildConfig c = build_config(write(sampled("sphere", 3000), "c.ply"), "m.slim");
    c.normals = "keep", c.sensors = file("c.scans.json");
    EXPECT_EQ(code_of([&] { build(c); }), ExitCode::usage);
    EXPECT_NE(message_.find("sensors"), std::string::npos) << message_;
}

TEST_F(BuildStage, EveryOptionCounts) {
    const std::string cloud = scanned_sphere(5000);
    build(build_config(cloud, "plain.slim"));
    const std::string plain = read_bytes(file("plain.slim"));
    const auto bytes_with = [&](auto&& change) {
        auto config = build_config(cloud, "other.slim");
        change(config);
        build(config);
        return read_bytes(file("other.slim"));
    };
    EXPECT_EQ(bytes_with([](BuildConfig&) {}), plain);
    EXPECT_NE(bytes_with([](BuildConfig& c) { c.degree = "3"; }), plain);
    EXPECT_NE(bytes_with([](BuildConfig& c) { c.degree = "auto"; }), plain);
    EXPECT_NE(bytes_with([](BuildConfig& c) { c.radius_rule = "windows"; }), plain);
    EXPECT_NE(bytes_with([](BuildConfig& c) { c.weight = "polynomial"; }), plain);
    for (const char* cover : {"A", "C"})
        EXPECT_NE(bytes_with([&](BuildConfig& c) { c.cover = cover; }), plain);
    EXPECT_NE(bytes_with([](BuildConfig& c) { c.lambda = 1e-5; }), plain);
    EXPECT_NE(bytes_with([](BuildConfig& c) { c.normals = "estimate"; }), plain);
    EXPECT_NE(bytes_with([](BuildConfig& c) { c.seed = 1; }), plain);
    EXPECT_NE(bytes_with([](BuildConfig& c) { c.slices = 2; }), plain);
}

/// A cube's surface on a grid; vertices of edges and corners have the mean normal of their faces.
std::string cube_text(int n) {
    std::string text;
    for (int x = 0; x <= n; ++x)
        for (int y = 0; y <= n; ++y)
            for (int z = 0; z <= n; ++z) {
                const auto side = [n](int k) { return k == 0 ? -1.0 : k == n ? 1.0 : 0.0; };
                const Vec3d normal = normalized(Vec3d{side(x), side(y), side(z)});
                if (!(sq_length(normal) > 0)) continue;
                for (const double v :
                     {double(x), double(y), double(z), normal.x, normal.y, normal.z})
                    text += std::to_string(v) + ' ';
                text += '\n';
            }
    return text;
}

TEST_F(BuildStage, TheModelSaysWhatItWasFittedWith) {
    const std::string cloud = scanned_sphere(5000);
    const auto info_of = [&](const BuildConfig& config) {
        build(config);
        InfoConfig info;
        info.file = config.output;
        Reporter silent;
        return run_as("info", info, run_info, silent);
    };
    auto config = build_config(cloud, "m.slim");
    const auto plain = info_of(config);
    EXPECT_EQ(plain["fit"].dump(),
              R"({"cover":"B","degree":2,"radius_rule":"ladder","sharp":false,"weight":"gauss"})");
    config.degree = "auto";
    config.weight = "polynomial";
    config.cover = "C";
    EXPECT_EQ(info_of(config)["fit"].dump(),
              R"({"cover":"C","degree":"auto","radius_rule":"ladder","sharp":false,)"
              R"("weight":"polynomial"})");
    config.degree = "3";
    config.radius_rule = "windows";
    EXPECT_EQ(info_of(config)["fit"]["radius_rule"], "windows");
}

TEST_F(BuildStage, NormalsBetterThanThePointsMakeCurvatureBetter) {
    const std::string cloud = write(sampled("bumpy", 30000, 1, 1e-3), "bumpy.ply");
    auto config = build_config(cloud, "m.slim");
    config.degree = "3";
    build(config);
    const auto followed = measure(config.output, cloud);
    config.normals = "estimate";
    build(config);
    const auto alone = measure(config.output, cloud);
    for (const char* key : {"normal_rms_deg", "k1_rms", "k2_rms", "mean_curvature_rms"})
        EXPECT_LT(followed[key].get<double>(), 0.5 * alone[key].get<double>()) << key;
    EXPECT_LT(followed["l2"].get<double>(), 1.05 * alone["l2"].get<double>());
}

TEST_F(BuildStage, EveryLeafOfALowerDegreeHasACause) {
    // A cube's corners, a scan with noise: forced leaves, too few points, contrary normals.
    const std::string cube = folder_.write("cube.xyz", cube_text(24));
    const std::string noisy = write(sampled("bumpy", 3000, 1, 5e-3), "noisy.ply");
    for (const std::string& cloud : {cube, noisy})
        for (const int slices : {1, 3}) {
            SCOPED_TRACE(testing::Message() << cloud << ", slices " << slices);
            auto config = build_config(cloud, "m.slim");
            config.degree = "3";
            config.slices = slices;
            build(config);
            InfoConfig info;
            info.file = config.output;
            Reporter silent;
            const auto found = run_as("info", info, run_info, silent);
            std::uint64_t lower = 0, causes = 0;
            for (const auto& [degree, n] : found["leaves_by_degree"].items())
                if (degree != "3") lower += n.get<std::uint64_t>();
            for (const char* cause : {"few_points", "rank", "steep", "plane", "lower_explains"})
                causes += found["fallbacks"].at(cause).get<std::uint64_t>();
            EXPECT_EQ(causes, lower);
            if (cloud == cube) {
                EXPECT_GT(found["fallbacks"].at("contrary").get<int>(), 0);
                EXPECT_GT(lower, 0u);
            }
        }
}

TEST_F(BuildStage, WindowsRefuseWhatTheyDoNotKnow) {
    const std::string cloud = scanned_sphere(500);
    auto config = build_config(cloud, "m.slim");
    config.radius_rule = "windows";
    config.degree = "auto";
    EXPECT_THROW(build(config), ConfigError);
    config.degree = "2";
    config.sharp = "on";
    EXPECT_THROW(build(config), ConfigError);
    EXPECT_FALSE(std::filesystem::exists(file("m.slim.work")));  // refused before any work
}

TEST_F(BuildStage, SharpIsExactOnACubeInAnySlicesAndDegree) {
    const std::string cloud = folder_.write("cube.xyz", cube_text(24));
    for (const int degree : {1, 2, 3})
        for (const int slices : {1, 3}) {
            SCOPED_TRACE(testing::Message() << "degree " << degree << ", slices " << slices);
            auto config = build_config(cloud, "m.slim");
            config.degree = std::to_string(degree);
            config.slices = slices;
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

TEST_F(BuildStage, TooFewPointsAreRefusedWithExit3) {
    const std::string two = folder_.write("two.xyz", "0 0 0\n1 1 1\n");
    EXPECT_EQ(code_of([&] { build(build_config(two, "m.slim")); }), ExitCode::bad_data);
    EXPECT_NE(message_.find("at least 3 points"), std::string::npos) << message_;
    const std::string equal = folder_.write("equal.xyz", "1 2 3\n1 2 3\n1 2 3\n1 2 3\n");
    EXPECT_EQ(code_of([&] { build(build_config(equal, "m.slim")); }), ExitCode::bad_data);
    EXPECT_FALSE(fs::exists(file("m.slim")));
}

TEST_F(BuildStage, AFewPointsMakeAModel) {
    const std::string nine = folder_.write(
        "nine.xyz", "0 0 0\n1 0 0\n2 0 0\n0 1 0\n1 1 0.1\n2 1 0\n0 2 0\n1 2 0\n2 2 0\n");
    const auto result = build(build_config(nine, "m.slim"));
    EXPECT_GE(result["leaves"].get<int>(), 1);
}

TEST_F(BuildStage, ADistantCloudLosesNoDetail) {
    // NUMERICS section 6, 4: as the run at the origin.
    Cloud cloud = sampled("sphere", 10000);
    for (Vec3d& p : cloud.positions) p = to_double(to_float(p));  // survives the shift in doubles
    const std::string near = write(cloud, "near.ply");
    build(build_config(near, "near.slim"));
    for (Vec3d& p : cloud.positions) p += Vec3d{1048576, 0, -2097152};
    const std::string far = write(cloud, "far.ply");
    build(build_config(far, "far.slim"));
    const auto a = measure(file("near.slim"), near), b = measure(file("far.slim"), far);
    EXPECT_NEAR(b["leaves"].get<double>() / a["leaves"].get<double>(), 1, 0.01);
    EXPECT_NEAR(b["l2"].get<double>() / a["l2"].get<double>(), 1, 0.01);
}

}  // namespace
}  // namespace slim::test
