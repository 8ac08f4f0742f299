#include "slim/cover/level_cover.h"

#include "slim/base/parallel.h"
#include "tests/slim/cover/cover_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace slim::test {
namespace {

/// Bytes that the leaves' records and nodes take.
double bytes_of(const Cover& c) {
    double sum = 0;
    for (const FittedSurfel& s : leaves_of(c))
        sum += 4.0 * floats_per_surfel(s.surfel.degree) + sizeof(TreeNode);
    return sum;
}

CoverRules choosing(CoverRules rules) {
    rules.degree = 3;
    rules.ladder.choose_degree = true;
    return rules;
}

TEST(LevelCover, TheSmallestLeavesOfACleanSurfaceKeepTheirDegree) {
    // T so small that nearly all leaves are as small as the points allow: some 20 lean by chance,
    // more have fewer effective points than an estimate wants.
    for (const char* shape : {"torus", "bumpy"})
        for (const int degree : {2, 3}) {
            SCOPED_TRACE(testing::Message() << shape << ", degree " << degree);
            const PointBlock block = block_of(sampled(shape, 20000, 2));
            const Cover c = cover(block, rules_for(block, 1e-6, degree));
            ASSERT_GT(c.counts.leaves, 1000u);
            EXPECT_EQ(c.counts.degrees[static_cast<std::size_t>(degree)], c.counts.leaves);
            EXPECT_EQ(c.counts.fallbacks[static_cast<std::size_t>(Fallback::few_points)], 0u);
        }
}

TEST(LevelCover, WithTheDegreeChosenAPlaneIsPlanes) {
    const PointBlock block = graph_points(20000, 1, 1, [](double, double) { return 0.0; });
    const Cover c = cover(block, choosing(rules_for(block)));
    ASSERT_GT(c.counts.leaves, 0u);
    EXPECT_EQ(c.counts.degrees[1], c.counts.leaves);
    EXPECT_EQ(c.counts.saturated, c.counts.leaves);
}

TEST(LevelCover, WithTheDegreeChosenEachPartTakesItsOwn) {
    // Left a plane, right a wave that asks for curvature.
    const PointBlock block = graph_points(40000, 1, 1, [](double u, double) {
        return u < 0 ? 0.0 : 0.02 * (1 - std::cos(8 * u));
    });
    CoverRules rules = rules_for(block, 0.02);
    rules.noise_variance = 1e-8;
    const Cover chosen = cover(block, choosing(rules));
    for (const FittedSurfel& s : leaves_of(chosen)) {
        if (s.surfel.center.x < -s.surfel.support_radius) {
            ASSERT_EQ(s.surfel.degree, 1);
        }
        if (s.surfel.center.x > s.surfel.support_radius) {
            ASSERT_GE(s.surfel.degree, 2);
        }
    }
    // No degree for all of it is as sparse.
    for (int degree = 1; degree <= 3; ++degree) {
        rules.degree = degree;
        EXPECT_LT(bytes_of(chosen), bytes_of(cover(block, rules))) << degree;
    }
}

TEST(LevelCover, WithTheDegreeChosenItIsTheSameForAnyNumberOfThreads) {
    const PointBlock block = block_of(sampled("bumpy", 20000, 1, 1e-3));
    const CoverRules rules = choosing(rules_for(block, 0.005));
    std::vector<Cover> covers;
    for (const int n : {1, 2, 7}) {
        const ThreadLimit limit(n);
        covers.push_back(cover(block, rules));
    }
    expect_same(covers[0], covers[1]);
    expect_same(covers[0], covers[2]);
}

}  // namespace
}  // namespace slim::test
