#include "pipeline/scan_stage.h"

#include "formats/truth_file.h"
#include "slim/base/error.h"
#include "slim/shapes/shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace slim {
namespace {

namespace fs = std::filesystem;

class ScanStage : public testing::Test {
protected:
    ScanStage() {
        fs::create_directories(folder_);
        config_.output = (folder_ / "cloud.ply").string();
        config_.shape = "sphere";
        config_.points = 1'234;
    }
    ~ScanStage() override { fs::remove_all(folder_); }

    nlohmann::json run() {
        StageContext parent{silent_, 1, false, "", "", "", "", {}};
        StageContext context = for_stage(parent, "scan", config_);
        return run_scan(config_, context);
    }
    std::string bytes(const fs::path& file) const {
        std::ifstream in(file, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    std::string header() const {
        const std::string all = bytes(config_.output);
        return all.substr(0, all.find("end_header\n"));
    }

    fs::path folder_ = fs::temp_directory_path() /
                       ("scan_stage_" + std::string(testing::UnitTest::GetInstance()
                                                        ->current_test_info()
                                                        ->name()));
    Reporter silent_;
    ScanConfig config_;
};

TEST_F(ScanStage, WritesCloudTruthAndSensors) {
    config_.stations = 3;
    const nlohmann::json result = run();
    EXPECT_EQ(result["points"], 1'234);
    EXPECT_EQ(result["stations"], 3);
    const auto truth = read_truth(truth_path(config_.output), 1'234);
    for (const PointTruth& t : truth) ASSERT_NEAR(t.k1, 1, 1e-9);
    const auto scans = nlohmann::json::parse(bytes(scans_path(config_.output)));
    ASSERT_EQ(scans["scans"].size(), 3u);
    EXPECT_NE(header().find("property ushort scan"), std::string::npos);
    EXPECT_NE(header().find("comment slim sensor 2 "), std::string::npos);
    EXPECT_NE(header().find("property float nx"), std::string::npos);
    EXPECT_NE(header().find("property float x"), std::string::npos);
}

TEST_F(ScanStage, ASecondRunIsUpToDateUntilAnOptionChanges) {
    run();
    EXPECT_TRUE(run().contains("up_to_date"));
    const std::string before = bytes(config_.output);
    config_.seed = 2;
    config_.noise = 1e-3;
    EXPECT_FALSE(run().contains("up_to_date"));
    EXPECT_NE(bytes(config_.output), before);
}

TEST_F(ScanStage, AnOffsetMovesPointsAndSensorsInDoubles) {
    config_.ascii = true;
    config_.normals = false;
    config_.points = 10;
    config_.stations = 1;
    run();
    const std::string plain = bytes(config_.output);
    config_.offset = {400'000.5, 3e6, -7};
    run();
    const std::string moved = bytes(config_.output);
    EXPECT_NE(moved.find("property double x"), std::string::npos);
    EXPECT_EQ(moved.find("property float nx"), std::string::npos);
    const auto first = [](const std::string& ply) {
        return std::stod(ply.substr(ply.find("end_header\n") + 11));
    };
    EXPECT_NEAR(first(moved) - first(plain), 400'000.5, 1e-6);
    const auto scans = nlohmann::json::parse(bytes(scans_path(config_.output)));
    EXPECT_GT(scans["scans"][0]["position"][0], 399'990.0);
}

TEST_F(ScanStage, TheUniformPatternHasNoSensors) {
    config_.pattern = "uniform";
    const nlohmann::json result = run();
    EXPECT_EQ(result["stations"], 0);
    EXPECT_EQ(header().find("sensor"), std::string::npos);
    EXPECT_EQ(header().find("property ushort scan"), std::string::npos);
}

TEST_F(ScanStage, RefusesOptionsWithoutEffect) {
    const auto refused = [&](const auto& set) {
        const ScanConfig usual = config_;
        set(config_);
        EXPECT_THROW(run(), ConfigError);
        config_ = usual;
    };
    refused([](ScanConfig& c) { c.pattern = "uniform", c.stations = 3; });
    refused([](ScanConfig& c) { c.pattern = "uniform", c.dropout = 0.1; });
    EXPECT_FALSE(fs::exists(config_.output));
    config_.noise_model = "isotropic", config_.pattern = "uniform";
    EXPECT_NO_THROW(run());
}

TEST_F(ScanStage, RefusesAnotherFormatAndAHalfOffset) {
    config_.offset = {0, 1e300, 0};  // all points of the shape would have one y
    EXPECT_THROW(run(), ConfigError);
    config_.offset = {1, 2};
    EXPECT_THROW(run(), ConfigError);
    config_.offset.clear();
    config_.output = (folder_ / "cloud.las").string();
    EXPECT_THROW(run(), ConfigError);
}

TEST_F(ScanStage, OffersEveryShape) {
    const FieldList fields = fields_of(config_);
    EXPECT_EQ(fields.find("shape")->choices, shape_names());
}

}  // namespace
}  // namespace slim
