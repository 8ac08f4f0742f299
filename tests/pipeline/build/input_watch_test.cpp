#include "pipeline/build/slice_stage.h"

#include "tests/pipeline/build/fit_stages_support.h"

#include <gtest/gtest.h>

#include <fstream>

namespace slim::test {
namespace {

/// Adds points to a file when the first reading of it has ended.
class Meddler : public Reporter {
public:
    explicit Meddler(std::string path) : path_(std::move(path)) {}
    void progress(std::string_view what, std::uint64_t done, std::uint64_t total) override {
        if (what != "reading" || done != total || meddled_) return;
        meddled_ = true;
        std::ofstream(path_, std::ios::app) << "0.5 0.5 0.5\n0.25 0.25 0.25\n";
    }

private:
    std::string path_;
    bool meddled_ = false;
};

class InputWatchTest : public FitStages {};

TEST_F(InputWatchTest, AFileThatGrowsBetweenReadingsIsBadDataThatIsNamed) {
    SliceConfig config;
    config.inputs = {file("c.xyz")};
    config.work = file("work");
    std::ofstream(config.inputs[0]) << "0 0 0\n1 0 0\n0 1 0\n1 1 1\n";
    Meddler meddler(config.inputs[0]);
    EXPECT_EQ(code_of([&] { run_as("slice", config, run_slice, meddler); }), ExitCode::bad_data);
    EXPECT_NE(message_.find("c.xyz: changed while it was read"), std::string::npos) << message_;
    EXPECT_EQ(code_of([&] { run_as("slice", config, run_slice, listener_); }), ExitCode::ok);
}

}  // namespace
}  // namespace slim::test
