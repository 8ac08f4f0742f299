#include "slim/fit/variance_bins.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace slim::test {
namespace {

TEST(VarianceBins, QuantilesAreTheUpperEndsOfBins) {
    VarianceBins bins;
    for (int i = 1; i <= 100; ++i) bins.add(i, 0.5);
    for (const double share : {0.1, 0.5, 0.95, 1.0}) {
        SCOPED_TRACE(share);
        EXPECT_GT(bins.quantile(share), 100 * share);
        EXPECT_LE(bins.quantile(share), 125 * share);  // a bin of four an octave
    }
    EXPECT_EQ(VarianceBins().quantile(0.5), 0);
}

TEST(VarianceBins, MeansLeaveOutWhatBeginsAbove) {
    VarianceBins bins;
    for (const double v : {1.0, 1.1, 2.0, 1000.0}) bins.add(v, v / 1000);
    const VarianceBins::Bin few = bins.mean_up_to(10), all = bins.mean_up_to(INFINITY);
    EXPECT_EQ(few.n, 3u);
    EXPECT_DOUBLE_EQ(few.variance, 4.1 / 3);
    EXPECT_DOUBLE_EQ(few.flatness, 4.1e-3 / 3);
    EXPECT_EQ(all.n, 4u);
    EXPECT_DOUBLE_EQ(all.variance, 1004.1 / 4);
    EXPECT_EQ(bins.mean_up_to(0.5).n, 0u);
    EXPECT_EQ(bins.mean_up_to(0.5).variance, 0);
}

TEST(VarianceBins, ZerosAndPowersOfTwoHaveBinsOfTheirOwn) {
    VarianceBins bins;
    bins.add(0, 0);
    EXPECT_EQ(bins.mean_up_to(0).n, 1u);
    EXPECT_EQ(bins.quantile(1), 0);
    for (const double v : {0.25, 1e-30, 3.0, 1e20}) {
        VarianceBins one, scaled;
        one.add(v, 0), scaled.add(std::ldexp(v, -40), 0);
        EXPECT_EQ(std::ldexp(one.quantile(1), -40), scaled.quantile(1));
        EXPECT_EQ(one.mean_up_to(v).n, 1u);
        EXPECT_EQ(one.mean_up_to(v / 2).n, 0u);
        EXPECT_GT(one.quantile(1), v);
    }
}

TEST(VarianceBins, JoinedOnesAreThoseOfAll) {
    VarianceBins all, half, joined;
    for (int i = 0; i < 50; ++i) {
        all.add(1 + i * i, 0.25);
        (i % 2 ? half : joined).add(1 + i * i, 0.25);
    }
    for (const auto& [bin, b] : half.bins()) joined.add(bin, b);
    ASSERT_EQ(joined.bins().size(), all.bins().size());
    for (const auto& [bin, b] : all.bins()) {
        EXPECT_EQ(joined.bins().at(bin).n, b.n);
        EXPECT_EQ(joined.bins().at(bin).variance, b.variance);
        EXPECT_EQ(joined.bins().at(bin).flatness, b.flatness);
    }
}

}  // namespace
}  // namespace slim::test
