#include "slim/base/hash.h"
#include "tests/pipeline/build/fit_stages_support.h"
#include "tests/pipeline/extremes_support.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

// NUMERICS section 6, rows of normals: extremes_test.cpp.

namespace slim::test {
namespace {

TEST_F(Extremes, Row21AThinSheetWithoutNormalsBecomesOneSurfaceHalfway) {
    // Two layers 0.3 spacings apart, points in either at random. Without normals nothing tells them
    // from one noisy sheet: that is the documented failure, with a warning. With normals they stay
    // two: LevelCover.Row20AThinSheetsLeavesStayOnTheirSide.
    constexpr double gap = 0.3 * 2 / 100;  // 10,000 points a layer over [-1, 1]^2
    std::vector<Vec3d> points;
    for (std::uint64_t i = 0; i < 20000; ++i)
        points.push_back({2 * unit_interval(keyed_hash(1, i)) - 1,
                          2 * unit_interval(keyed_hash(2, i)) - 1,
                          i % 2 == 0 ? gap / 2 : -gap / 2});
    const std::string cloud = write_text("sheet.xyz", points);
    const auto result = built(cloud);
    const auto m = measure(file("m.slim"), cloud);
    EXPECT_EQ(m["missed"], 0);
    EXPECT_TRUE(warned_of("between two layers"));
    const double half = m["l2"].get<double>() * m["diagonal"].get<double>();
    EXPECT_NEAR(half / (gap / 2), 1, 0.05);
    EXPECT_LT(m["max"].get<double>() * m["diagonal"].get<double>(), gap);
    // lambda takes the gap for noise: 0.7 (gap / 2)^2 of ten neighbours less a plane's freedom.
    EXPECT_NEAR(result["noise_variance"].get<double>() / (gap * gap / 4), 0.65, 0.2);
}

TEST_F(Extremes, Row27UpToATenthOfFlippedNormalsDoNoHarmMoreAreEstimatedAnew) {
    const Cloud clean = sampled("sphere", 20000);
    const std::string truth = write(clean, "truth.ply");
    built(truth, "clean.slim");
    const auto reference = measure(file("clean.slim"), truth);
    for (const double share : {0.01, 0.05, 0.09, 0.2, 0.35, 0.5, 0.52, 0.6, 0.7}) {
        SCOPED_TRACE(share);
        listener_.warnings.clear();
        Cloud flipped = clean;
        for (std::size_t i = 0; i < clean.size(); ++i)
            if (unit_interval(keyed_hash(1, i)) < share) flipped.normals[i] = -flipped.normals[i];
        const auto result = built(write(flipped, "flipped.ply"));
        const bool many = share > 0.1;
        EXPECT_EQ(warned_of("estimated anew"), many);
        EXPECT_EQ(result["normals_estimated"].get<std::uint64_t>(), many ? 20000u : 0u);
        if (!many) {
            EXPECT_NEAR(result["normals_turned"].get<double>(), share * 20000,
                        0.1 * share * 20000 + 10);
        }
        const auto m = measure(file("m.slim"), truth);
        EXPECT_EQ(m["missed"], 0);
        EXPECT_EQ(m["opposed"], 0);  // against the truth: no side is turned
        EXPECT_NEAR(m["leaves"].get<double>() / reference["leaves"].get<double>(), 1, 0.1);
        EXPECT_LT(m["l2"].get<double>(), 1.5 * reference["l2"].get<double>());
    }
}

TEST_F(Extremes, Row28ZeroNormalsAreEstimatedAndCounted) {
    Cloud cloud = sampled("sphere", 10000);
    const std::string truth = write(cloud, "truth.ply");
    std::size_t zeros = 0;
    for (std::size_t i = 0; i < cloud.size(); i += 3, ++zeros) cloud.normals[i] = {};
    const auto result = built(write(cloud, "zeros.ply"));
    EXPECT_EQ(result["normals_estimated"], zeros);
    EXPECT_EQ(result["stages"]["normals"]["kept"], 10000 - zeros);
    const auto m = measure(file("m.slim"), truth);
    EXPECT_EQ(m["missed"], 0);
    EXPECT_EQ(m["opposed"], 0);
}

TEST_F(Extremes, Row28NormalsOfAnyLengthAreKept) {
    Cloud cloud = sampled("sphere", 5000);
    for (const float size : {1e-25f, 1e25f, 1e-40f, 3e38f}) {
        SCOPED_TRACE(size);
        Cloud scaled = cloud;
        for (Vec3f& n : scaled.normals) n = n * size;
        const auto result = built(write(scaled, "scaled.ply"));
        EXPECT_EQ(result["normals_estimated"], 0);
        EXPECT_EQ(result["stages"]["normals"]["kept"], 5000);
    }
}

}  // namespace
}  // namespace slim::test
