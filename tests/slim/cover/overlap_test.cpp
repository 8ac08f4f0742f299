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

}  // namespace
}  // namespace slim::test
