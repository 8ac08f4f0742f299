#include "slim/cover/overlap.h"

#include <gtest/gtest.h>

namespace slim::test {
namespace {

TEST(Overlap, ALoneLeafCoversAsFarAsItsReadingSays) {
    // NUMERICS 3.4, third decimal; alpha was 0.666.. there too.
    const std::pair<CoverReading, float> cases[] = {
        {CoverReading::a, 0.357f}, {CoverReading::b, 0.536f}, {CoverReading::c, 0.702f}};
    for (const auto& [reading, radius] : cases) {
        const auto gamma = static_cast<float>(kCoverage);
        const float in = radius - 0.001f, out = radius + 0.001f;
        EXPECT_GT(overlap_weight(reading, in * in), gamma);
        EXPECT_LT(overlap_weight(reading, out * out), gamma);
    }
}

TEST(Overlap, VanishesAtTheEndOfItsSupport) {
    const auto core = static_cast<float>(kTrim * kTrim);
    EXPECT_EQ(overlap_weight(CoverReading::a, core), 0);
    EXPECT_GT(overlap_weight(CoverReading::b, core), 0);
    for (const CoverReading reading : {CoverReading::a, CoverReading::b, CoverReading::c}) {
        EXPECT_EQ(overlap_weight(reading, 1), 0);
        EXPECT_EQ(overlap_weight(reading, 2), 0);
    }
}

TEST(Overlap, ALimitedLeafThatIsBetterThanAskedCountsMoreOften) {
    EXPECT_EQ(limited_times(0.1, 1), 1);
    EXPECT_FLOAT_EQ(limited_times(0.5, 1), 3);
    EXPECT_EQ(limited_times(2, 1), kLimitedTimes);
    EXPECT_EQ(limited_times(1, 0), kLimitedTimes);
    EXPECT_EQ(limited_times(0, 0), 1);
}

}  // namespace
}  // namespace slim::test
