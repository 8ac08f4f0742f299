#include "pipeline/info/info_stage.h"
#include "tests/pipeline/build/build_stage_support.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slim::test {
namespace {

using DroppedPoints = BuildStage;

TEST_F(DroppedPoints, AreCountedByCauseInWhatInfoSaysOfTheModel) {
    Cloud cloud = sampled("sphere", 20000);
    for (std::size_t i = 0; i < 5; ++i)  // alone, within the cloud's box
        cloud.positions[100 * i] = {0.1 * static_cast<double>(i), 0, 0};
    for (const int slices : {1, 3}) {
        SCOPED_TRACE(slices);
        auto config = build_config(write(cloud, "strays.ply"), "m.slim");
        config.slices = slices;
        const auto built = build(config);
        InfoConfig info;
        info.file = config.output;
        Reporter silent;
        const auto dropped = run_as("info", info, run_info, silent).at("dropped");
        std::uint64_t n = 0;
        for (const char* cause : {"isolated", "beside", "unexplained"})
            n += dropped.at(cause).get<std::uint64_t>();
        EXPECT_GE(n, 5u);
        std::uint64_t said = 0;
        for (const char* cause : {"dropped_isolated", "dropped_beside", "dropped_unexplained"})
            said += built.at(cause).get<std::uint64_t>();
        EXPECT_EQ(said, n);
        EXPECT_EQ(built.at("dropped"), 0);
    }
}

TEST_F(DroppedPoints, OfABuildAreThoseThatAreNotFinite) {
    Cloud cloud = sampled("sphere", 3000);
    for (std::size_t i = 0; i < 40; ++i) cloud.positions[10 * i].y = NAN;
    const auto config = build_config(write(cloud, "nan.ply"), "m.slim");
    StageContext context{listener_, 1, false, "build", "", "", "", {}};
    const auto built = run_build(config, context);
    EXPECT_EQ(built.at("dropped"), 40);
    EXPECT_NE(context.text.find("not finite, dropped: 40 points"), std::string::npos)
        << context.text;
}

}  // namespace
}  // namespace slim::test
