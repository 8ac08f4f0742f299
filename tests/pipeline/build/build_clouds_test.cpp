#include "pipeline/build/build_stage.h"

#include "formats/slice_file.h"
#include "pipeline/input_kind.h"
#include "pipeline/scan_stage.h"
#include "tests/pipeline/build/build_stage_support.h"
#include "tests/pipeline/build/fit_stages_support.h"

#include <gtest/gtest.h>

#include <filesystem>

namespace slim::test {
namespace {

namespace fs = std::filesystem;

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

TEST_F(BuildStage, CloudsFarApartAreNotToldToBeALineAsWell) {
    Cloud far = sampled("sphere", 500);
    BuildConfig c = build_config(write(far, "here.ply"), "m.slim");
    for (Vec3d& p : far.positions) p += Vec3d{5e8, 5e8, 0};
    c.inputs.push_back(write(far, "far.ply"));
    code_of([&] { build(c); });
    std::string all;
    for (const std::string& said : listener_.warnings) all += said + "\n";
    EXPECT_NE(all.find("same frame?"), std::string::npos) << all;
    EXPECT_EQ(all.find("on one line"), std::string::npos) << all;
    EXPECT_EQ(all.find("a speck in"), std::string::npos) << all;
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
