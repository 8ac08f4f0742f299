#include "slim/cover/level_cover.h"

#include "slim/base/parallel.h"
#include "tests/slim/cover/cover_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace slim::test {
namespace {

TEST(LevelCover, Row20AThinSheetsLeavesStayOnTheirSide) {
    // Two planes 0.004 apart, points 0.014 apart.
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (std::size_t i = 0; i < 20000; ++i) {
        const bool top = i % 2 == 0;
        positions.push_back({random_at(1, 2 * i), random_at(1, 2 * i + 1), top ? 0.002 : -0.002});
        normals.push_back({0, 0, top ? 1.0f : -1.0f});
    }
    const PointBlock block = block_of(positions, normals);
    CoverRules rules = rules_for(block);
    rules.noise_variance = 1e-10;
    const Cover c = cover(block, rules);
    ASSERT_GT(c.counts.leaves, 0u);
    for (const FittedSurfel& s : leaves_of(c)) {
        const double side = positions[s.point_id].z > 0 ? 1 : -1;
        ASSERT_NEAR(s.surfel.frame.normal.z, side, 1e-9);
        // through its own sheet, not between the two
        ASSERT_NEAR(s.surfel.polynomial.a[0], 0, 1e-9);
        ASSERT_LT(s.fit_error, 1e-9);
    }
    EXPECT_LE(uncovered(block, c, rules.noise_variance), c.counts.unexplained + c.counts.isolated);
}

TEST(LevelCover, Row26AStrayPointMakesNoLeaf) {
    PointBlock block = graph_points(10000, 1, 2, [](double, double) { return 0.0; });
    for (const double height : {0.05, 0.1, 0.2, 0.3, 0.5, 2.0, 100.0}) {
        SCOPED_TRACE(height);
        block.position[17] = {0.1, 0.1, height};
        CoverRules rules = rules_for(block);
        rules.diagonal = std::sqrt(8.0);
        rules.noise_variance = 1e-10;
        const Cover c = cover(block, rules);
        EXPECT_EQ(c.counts.isolated + c.counts.unexplained, 1u);
        for (const FittedSurfel& s : leaves_of(c)) EXPECT_NE(s.point_id, 17u);
    }
}

TEST(LevelCover, APoleGetsNoDiscsOfTheSizeOfItsSearch) {
    // 60 points of a thin pole above a plane: a ball that holds enough of them for a fit is 0.15 in
    // radius.
    PointBlock block = graph_points(8000, 1, 3, [](double, double) { return 0.0; });
    for (std::size_t i = 0; i < 60; ++i) {
        const double z = 0.2 + 0.015 * static_cast<double>(i);
        block.position[i] = {0.002 * random_at(4, i), 0.002 * random_at(5, i), z};
        const auto angle = static_cast<double>(i);
        block.normal[i] = to_float(Vec3d{std::cos(angle), std::sin(angle), 0});
    }
    std::size_t on_pole = 0;
    for (const FittedSurfel& s : leaves_of(cover(block, rules_for(block)))) {
        if (s.surfel.center.z < 0.15) continue;
        ++on_pole;
        EXPECT_LT(s.surfel.support_radius, 0.09) << s.surfel.center.z;
    }
    EXPECT_GT(on_pole, 5u);
}

TEST(LevelCover, AClumpInTheAirGetsNoDiscFarBeyondIt) {
    // 20 points of one normal, 0.6 above a plane: any ball up to there holds them all.
    PointBlock block = graph_points(8000, 1, 3, [](double, double) { return 0.0; });
    for (std::size_t i = 0; i < 20; ++i)
        block.position[i] = {0.05 * random_at(4, i), 0.05 * random_at(5, i),
                             0.6 + 0.002 * random_at(6, i)};
    std::size_t on_clump = 0;
    for (const FittedSurfel& s : leaves_of(cover(block, rules_for(block)))) {
        if (s.surfel.center.z < 0.5) continue;
        ++on_clump;
        EXPECT_LT(s.surfel.support_radius, 0.2);
    }
    EXPECT_GE(on_clump, 1u);
}

TEST(LevelCover, NoLeafIsAsThickAsPointsAtRandom) {
    // A bush on a plane.
    PointBlock block = graph_points(8000, 1, 3, [](double, double) { return 0.0; });
    for (std::size_t i = 0; i < 150; ++i) {
        block.position[i] = {0.12 * random_at(4, i), 0.12 * random_at(5, i),
                             0.15 + 0.15 * random_at(6, i)};
        block.normal[i] = to_float(normalized(Vec3d{random_at(7, i), random_at(8, i), 1}));
    }
    for (const FittedSurfel& s : leaves_of(cover(block, rules_for(block)))) {
        if (s.n_points <= 3) continue;
        EXPECT_LE(s.fit_error, 0.25 * s.surfel.support_radius) << s.n_points;
    }
}

/// A noisy square sheet, and along its rim x = 1 points that a grazing beam put off it by 5 to 7
/// sigma, with normals turned outwards by 57 to 92 degrees.
PointBlock sheet_with_grazed_rim(double sigma, std::size_t n_rim) {
    PointBlock block = graph_points(40000, 1, 3, [](double, double) { return 0.0; });
    for (std::size_t i = 0; i < block.size(); ++i) block.position[i].z += sigma * gaussian(6, i);
    for (std::size_t i = 0; i < n_rim; ++i) {
        const double off = sigma * (5 + 2 * std::abs(random_at(7, i)));
        block.position[i] = {0.99 + 0.01 * random_at(8, i), random_at(9, i),
                             random_at(10, i) < 0 ? off : -off};
        const double angle = 1.3 + 0.3 * random_at(11, i);
        block.normal[i] = to_float(Vec3d{std::sin(angle), 0, std::cos(angle)});
    }
    return block;
}

/// Leaves of few sigma in radius whose normals are more than 20 degrees off the sheet's.
std::size_t n_scales(const Cover& c, double sigma) {
    std::size_t n = 0;
    for (const FittedSurfel& s : leaves_of(c))
        n += s.surfel.support_radius < 14 * sigma && s.surfel.frame.normal.z < 0.94;
    return n;
}

TEST(LevelCover, AGrazedRimOfARawScanGetsNoScales) {
    const PointBlock block = sheet_with_grazed_rim(4e-3, 150);
    CoverRules rules = rules_for(block);
    rules.noise_variance = 1.6e-5;
    const Cover clean = cover(block, rules);
    rules.ladder.contrary_share = 2e-3;
    std::vector<Cover> raw;
    for (const int n : {1, 2, 7}) {
        const ThreadLimit limit(n);
        raw.push_back(cover(block, rules));
    }
    EXPECT_EQ(clean.counts.beside, 0u);
    EXPECT_GT(n_scales(clean, 4e-3), 20u);
    EXPECT_GT(raw[0].counts.beside, 20u);
    EXPECT_LT(3 * n_scales(raw[0], 4e-3), n_scales(clean, 4e-3));
    EXPECT_LT(raw[0].counts.leaves, clean.counts.leaves);
    EXPECT_LE(uncovered(block, raw[0], rules.noise_variance),
              raw[0].counts.beside + raw[0].counts.unexplained + raw[0].counts.isolated);
    for (std::size_t i : {1, 2}) {
        expect_same(raw[0], raw[i]);
        EXPECT_EQ(raw[0].counts.beside, raw[i].counts.beside);
    }
}

TEST(LevelCover, FewPointsKeepTheirLeafWhereNoiseIsSmallAgainstIt) {
    // sqrt(lambda) is 0.03 of the radius of the smallest leaves: the same places are a detail here.
    const PointBlock block = sheet_with_grazed_rim(8e-4, 150);
    CoverRules rules = rules_for(block);
    rules.noise_variance = 6.4e-7;
    rules.ladder.contrary_share = 2e-3;
    const Cover c = cover(block, rules);
    EXPECT_EQ(c.counts.beside, 0u);
    EXPECT_GT(c.counts.forced, 5u);  // ten: each covers its core as a whole (slim/cover/notes/0010)
}

TEST(LevelCover, NothingIsCoveredFarFromTheDataOfAHole) {
    const Cloud plane = sampled("plane", 40000);
    const PointBlock block = block_of(filtered(plane, [](const Vec3d& p) {
        return p.x * p.x + p.y * p.y > 0.16;
    }));
    const Cover c = cover(block, rules_for(block));
    // Cores reach at most alpha rho_0 = 0.19 into the hole of radius 0.4: its middle stays open.
    double least = 1;
    for (const FittedSurfel& s : leaves_of(c))
        least = std::min(least, std::hypot(s.surfel.center.x, s.surfel.center.y) -
                                    kTrim * s.surfel.support_radius);
    EXPECT_GT(least, 0.4 - kTrim * box_of(block).diagonal() / 10 - 1e-6);
    for (const FittedSurfel& s : leaves_of(c))
        EXPECT_GT(std::hypot(s.surfel.center.x, s.surfel.center.y), 0.4);
}

TEST(LevelCover, TwelvefoldDuplicatesGiveAboutTheUniqueSet) {
    const PointBlock unique = block_of(sampled("sphere", 4000));
    PointBlock all;
    for (std::uint64_t copy = 0; copy < 12; ++copy)
        for (std::size_t i = 0; i < unique.size(); ++i) {
            all.position.push_back(unique.position[i]);
            all.normal.push_back(unique.normal[i]);
            all.id.push_back(all.id.size());
        }
    const CoverRules rules = rules_for(unique);
    const Cover a = cover(unique, rules), b = cover(all, rules);
    EXPECT_NEAR(static_cast<double>(b.counts.leaves) / static_cast<double>(a.counts.leaves), 1,
                0.1);
    EXPECT_LE(uncovered(all, b, rules.noise_variance), b.counts.unexplained + b.counts.isolated);
}

TEST(LevelCover, AFewPointsMakeAFewDiscs) {
    for (const std::size_t n : {3u, 5u, 9u, 30u}) {
        SCOPED_TRACE(n);
        const PointBlock block =
            graph_points(n, 1, 7, [](double u, double v) { return 0.1 * u * v; });
        const Cover c = cover(block, rules_for(block));
        EXPECT_GE(c.counts.leaves + c.counts.isolated + c.counts.unexplained, 1u);
        EXPECT_LE(c.counts.leaves, n);
        for (const FittedSurfel& s : c.surfels) {
            EXPECT_TRUE(std::isfinite(s.fit_error));
            for (const double a : s.surfel.polynomial.a) EXPECT_TRUE(std::isfinite(a));
        }
    }
}

}  // namespace
}  // namespace slim::test
