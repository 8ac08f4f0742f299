#include "slim/base/log_histogram.h"

#include <gtest/gtest.h>

namespace slim {
namespace {

TEST(LogHistogram, QuantilesAreThoseOfTheValuesToAThirdOfAPercent) {
    LogHistogram a, b;
    for (int i = 1; i <= 1000; ++i) (i % 2 == 0 ? a : b).add(1e-7 * i);
    a.add(b);
    ASSERT_EQ(a.size(), 1000u);
    for (const double share : {0.001, 0.5, 0.9, 0.99, 1.0})
        EXPECT_NEAR(a.quantile(share) / (1e-4 * share), 1, 0.003) << share;
}

TEST(LogHistogram, HoldsZerosAndExtremes) {
    LogHistogram h;
    EXPECT_EQ(h.quantile(0.5), 0);
    for (int i = 0; i < 3; ++i) h.add(0);
    h.add(1e300);
    EXPECT_EQ(h.quantile(0.75), 0);
    EXPECT_GT(h.quantile(1), 1e38);
}

TEST(LogHistogram, NoQuantileIsAboveTheLargestValue) {
    for (const double value : {1.0, 1.001, 1.0023, 1.0039, 3.7e-5}) {
        LogHistogram h, other;
        h.add(value / 2), other.add(value);
        h.add(other);
        for (const double share : {0.9, 0.99, 1.0}) {
            EXPECT_LE(h.quantile(share), value);
            EXPECT_GT(h.quantile(share), 0.99 * value);
        }
    }
}

}  // namespace
}  // namespace slim
