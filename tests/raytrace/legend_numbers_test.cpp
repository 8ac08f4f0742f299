#include "raytrace/legend_numbers.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <vector>

namespace slim {
namespace {

/// "1" for each tick with a number, "0" for the others; ticks 100 apart.
std::string chosen(const std::vector<double>& ticks, float width) {
    std::vector<NumberSpan> spans;
    for (std::size_t i = 0; i < ticks.size(); ++i) {
        const auto at = 100 * static_cast<float>(i);
        spans.push_back({at - width / 2, at + width / 2});
    }
    const NumberChoice choice = numbers_apart(ticks, spans, 10);
    std::string out;
    for (std::size_t i = 0; i < ticks.size(); ++i) out += choice.has(i) ? '1' : '0';
    return out;
}

TEST(LegendNumbers, AllWhereThereIsRoom) {
    EXPECT_EQ(chosen({0, 1, 2, 3, 4, 5}, 80), "111111");
    EXPECT_EQ(chosen({-2, -1, 0, 1, 2}, 80), "11111");
}

// The end of a range is what one reads first.
TEST(LegendNumbers, TheEndHasItsNumberAndOneTooNearToItHasNone) {
    EXPECT_EQ(chosen({0, 1, 2, 3, 4, 5}, 150), "101001");
    EXPECT_EQ(chosen({0, 1, 2, 3, 4}, 150), "10101");
    EXPECT_EQ(chosen({0, 1, 2, 3, 4, 5}, 250), "100001");
}

TEST(LegendNumbers, ZeroAloneWhereTheEndWouldTouchIt) {
    EXPECT_EQ(chosen({0, 1}, 150), "10");
    EXPECT_EQ(chosen({-1, 0, 1}, 150), "010");
    EXPECT_EQ(chosen({0}, 150), "1");
}

}  // namespace
}  // namespace slim
