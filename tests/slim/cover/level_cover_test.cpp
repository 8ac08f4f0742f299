#include "slim/cover/level_cover.h"

#include "slim/base/parallel.h"
#include "slim/model/surfel_tree.h"
#include "tests/slim/fit/noise_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <set>
#include <vector>

namespace slim::test {
namespace {

CoverRules rules_for(const PointBlock& block, double mdl_threshold = 0.02, int degree = 2) {
    CoverRules rules;
    rules.degree = degree;
    rules.mdl_threshold = mdl_threshold;
    rules.diagonal = box_of(block).diagonal();
    rules.least_radius = rules.diagonal * 1e-15;
    const double measured = measured_noise(block.position, 0, 10000).value;
    const double quantum = rules.diagonal * 2.2e-16;
    rules.noise_variance = std::max(measured, 16 * quantum * quantum);
    return rules;
}

Cover cover(const PointBlock& block, const CoverRules& rules) {
    Reporter silent;
    return cover_points(block, rules, silent);
}

std::vector<FittedSurfel> leaves_of(const Cover& c) {
    std::vector<FittedSurfel> out;
    std::copy_if(c.surfels.begin(), c.surfels.end(), std::back_inserter(out),
                 [](const FittedSurfel& s) { return (s.flags & kLeaf) != 0; });
    return out;
}

bool same(const FittedSurfel& a, const FittedSurfel& b) {
    return a.surfel.center == b.surfel.center && a.surfel.support_radius == b.surfel.support_radius &&
           a.surfel.frame.normal == b.surfel.frame.normal &&
           a.surfel.frame.u_axis == b.surfel.frame.u_axis &&
           a.surfel.polynomial.a == b.surfel.polynomial.a && a.surfel.degree == b.surfel.degree &&
           a.fit_error == b.fit_error && a.n_points == b.n_points && a.level == b.level &&
           a.flags == b.flags && a.point_id == b.point_id;
}

void expect_same(const Cover& a, const Cover& b) {
    ASSERT_EQ(a.surfels.size(), b.surfels.size());
    for (std::size_t i = 0; i < a.surfels.size(); ++i) ASSERT_TRUE(same(a.surfels[i], b.surfels[i])) << i;
    EXPECT_EQ(a.counts.leaves, b.counts.leaves);
    EXPECT_EQ(a.counts.evaluated, b.counts.evaluated);
    EXPECT_EQ(a.counts.point_visits, b.counts.point_visits);
}

/// Points that are neither covered by the leaves nor the centre of one.
std::size_t uncovered(const PointBlock& block, const Cover& c, double noise_variance) {
    const PointTree tree = tree_of(block);
    std::vector<double> weight(block.size(), 0);
    std::vector<bool> core(block.size(), false);
    std::set<std::uint64_t> centers;
    BallPoints<double> work;
    for (const FittedSurfel& s : leaves_of(c)) {
        centers.insert(s.point_id);
        for (const Covered& p : cover_again(tree, s, noise_variance, work).covered) {
            weight[p.point] += p.weight;
            if (p.in_core) core[p.point] = true;
        }
    }
    std::size_t n = 0;
    for (std::size_t i = 0; i < block.size(); ++i)
        n += !(core[i] && weight[i] >= kCoverage - 1e-6) && !centers.contains(block.id[i]);
    return n;
}

double median_radius(const std::vector<FittedSurfel>& leaves) {
    std::vector<double> radii;
    for (const FittedSurfel& s : leaves) radii.push_back(s.surfel.support_radius);
    std::nth_element(radii.begin(), radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2),
                     radii.end());
    return radii[radii.size() / 2];
}

TEST(LevelCover, Row11LeavesOfASphereHaveTheOptimalRadius) {
    const PointBlock block = block_of(sampled("sphere", 100000));
    const CoverRules rules = rules_for(block, 0.02);
    const Cover c = cover(block, rules);
    const auto leaves = leaves_of(c);
    const double e = rules.noise_variance * 0.02 * 0.02 * rules.diagonal * rules.diagonal;
    const double optimum = std::pow(16 * e / 4.1003e-4, 0.1);  // NUMERICS 3.2, R = 1
    EXPECT_NEAR(median_radius(leaves) / optimum, 1, 0.03);
    // NUMERICS 3.4: a sphere filled with equal balls takes 177 of radius L / 10 = 0.3464.
    const double expected = 177 * 0.12 / (optimum * optimum);
    EXPECT_NEAR(static_cast<double>(leaves.size()) / expected, 1, 0.15);
    EXPECT_EQ(c.counts.leaves, leaves.size());
    EXPECT_EQ(c.counts.unexplained + c.counts.isolated + c.counts.forced, 0u);
    for (const FittedSurfel& s : leaves) {
        ASSERT_EQ(s.surfel.degree, 2);
        ASSERT_GT(dot(s.surfel.frame.normal, normalized(s.surfel.center)), 0.99);
        // w = -rho (u^2 + v^2) / 2 to the order of the fit.
        ASSERT_NEAR(s.surfel.polynomial.a[3], -s.surfel.support_radius / 2, 0.02);
    }
}

TEST(LevelCover, Row09APlaneIsSaturatedLeavesAtTheRoot) {
    const PointBlock block = graph_points(20000, 1, 1, [](double, double) { return 0.0; });
    const Cover c = cover(block, rules_for(block));
    ASSERT_GT(c.counts.leaves, 0u);
    EXPECT_EQ(c.counts.saturated, c.counts.leaves);
    EXPECT_EQ(c.counts.internals, 0u);
    // Centres are drawn from a thinning; what it left open waits a level or two for its large leaf.
    EXPECT_LE(c.counts.levels, 3u);
    const double root = box_of(block).diagonal() / 10;
    for (const FittedSurfel& s : c.surfels) {
        EXPECT_NEAR(s.surfel.support_radius, root, 1e-7);  // radii are kept as floats
        EXPECT_LT(s.fit_error, 1e-12 * box_of(block).diagonal());
    }
    // About C_ov area / (pi rho^2), C_ov 5.4 to 6.3 (NUMERICS 3.4); balls of the border lie half outside.
    const double balls = std::numbers::pi * root * root, side = 2 + 2 * root;
    EXPECT_GT(static_cast<double>(c.counts.leaves), 0.8 * 5.4 * 4 / balls);
    EXPECT_LT(static_cast<double>(c.counts.leaves), 6.3 * side * side / balls);
}

TEST(LevelCover, IsTheSameForAnyNumberOfThreads) {
    const PointBlock block = block_of(sampled("bumpy", 20000, 1, 1e-3));
    const CoverRules rules = rules_for(block, 0.005);
    std::vector<Cover> covers;
    for (const int n : {1, 2, 7}) {
        const ThreadLimit limit(n);
        covers.push_back(cover(block, rules));
    }
    ASSERT_GT(covers[0].surfels.size(), 200u);
    expect_same(covers[0], covers[1]);
    expect_same(covers[0], covers[2]);
}

TEST(LevelCover, ScalingByAPowerOfTwoScalesEveryBit) {
    PointBlock block = block_of(sampled("bumpy", 10000, 1, 1e-3));
    const CoverRules rules = rules_for(block);
    const Cover small = cover(block, rules);
    constexpr double s = 1024;
    for (Vec3d& p : block.position) p *= s;
    CoverRules scaled = rules;
    scaled.diagonal *= s, scaled.least_radius *= s, scaled.noise_variance *= s * s;
    Cover large = cover(block, scaled);
    for (FittedSurfel& f : large.surfels) {
        f.surfel.center *= 1 / s;
        f.surfel.support_radius /= s;
        f.fit_error /= s;
    }
    expect_same(small, large);
}

TEST(LevelCover, TheOrderOfThePointsDoesNotMatter) {
    const PointBlock block = block_of(sampled("bumpy", 10000, 1, 1e-3));
    const CoverRules rules = rules_for(block);
    const Cover a = cover(block, rules), b = cover(permuted(block, 5), rules);
    expect_same(a, b);
    CoverRules other = rules;
    other.seed = 1;
    const Cover c = cover(block, other);
    EXPECT_NE(a.surfels[0].point_id, c.surfels[0].point_id);
    EXPECT_NEAR(static_cast<double>(c.counts.leaves) / static_cast<double>(a.counts.leaves), 1, 0.15);
}

TEST(LevelCover, EveryPointIsCoveredOrCountedAsDropped) {
    for (const char* shape : {"torus", "cone", "bumpy", "sculpture"})
        for (const double noise : {0.0, 2e-3}) {
            SCOPED_TRACE(testing::Message() << shape << " noise " << noise);
            const PointBlock block = block_of(sampled(shape, 10000, 3, noise));
            const CoverRules rules = rules_for(block, 0.01);
            const Cover c = cover(block, rules);
            EXPECT_LE(uncovered(block, c, rules.noise_variance), c.counts.unexplained + c.counts.isolated);
            EXPECT_LT(c.counts.unexplained + c.counts.isolated, 50u);
            std::uint64_t degrees = 0, fallbacks = 0;
            for (const std::uint64_t n : c.counts.degrees) degrees += n;
            for (const std::uint64_t n : c.counts.fallbacks) fallbacks += n;
            EXPECT_EQ(degrees, c.counts.leaves);
            EXPECT_EQ(fallbacks, c.counts.leaves);
            EXPECT_EQ(c.counts.leaves + c.counts.internals, c.surfels.size());
        }
}

TEST(LevelCover, LevelsHoldTheRadiiOfTheirOrder) {
    const PointBlock block = block_of(sampled("sculpture", 20000));
    const CoverRules rules = rules_for(block, 0.003);
    const Cover c = cover(block, rules);
    int before = 1;
    for (const FittedSurfel& s : c.surfels) {
        EXPECT_GE(s.level, before);
        before = s.level;
        const double top = level_radius(rules.diagonal, s.level);
        if (s.flags & kLeaf)
            EXPECT_GE(s.surfel.support_radius, top * kGoldenRatio * kGoldenRatio * (1 - 1e-6));
        else
            EXPECT_EQ(s.surfel.support_radius, top);
    }
    EXPECT_GT(c.counts.internals, 0u);
    EXPECT_GT(before, 3);
}

TEST(LevelCover, LinearLeavesAreManyMoreAndCubicFewer) {
    const PointBlock block = block_of(sampled("bumpy", 20000));
    std::uint64_t leaves[4] = {};
    for (int degree = 1; degree <= 3; ++degree) {
        const Cover c = cover(block, rules_for(block, 0.01, degree));
        leaves[degree] = c.counts.leaves;
        EXPECT_EQ(c.counts.degrees[static_cast<std::size_t>(degree)], c.counts.leaves);
    }
    EXPECT_GT(leaves[1], 2 * leaves[2]);
    EXPECT_GT(leaves[2], leaves[3]);
}

TEST(LevelCover, TheReadingsOfTheCoverDifferAsTheirRadii) {
    const PointBlock block = block_of(sampled("sphere", 100000));
    CoverRules rules = rules_for(block, 0.02);
    const auto leaves = [&](CoverReading reading) {
        rules.reading = reading;
        return static_cast<double>(cover(block, rules).counts.leaves);
    };
    const double b = leaves(CoverReading::b);
    // NUMERICS 3.4: 400, 177 and 110 balls on a sphere, drawn in plain random order.
    EXPECT_NEAR(leaves(CoverReading::a) / b, 400.0 / 177, 0.25 * 400 / 177);
    // Leaves are not drawn so: centres far from others come first, and then cores hardly overlap.
    EXPECT_LT(leaves(CoverReading::c), 0.95 * b);
}

TEST(LevelCover, WindowsAreMoreAndSmallerUnderNoise) {
    const PointBlock block = block_of(sampled("bumpy", 50000, 1, 1e-3));
    CoverRules rules = rules_for(block, 0.01);
    const Cover ladder = cover(block, rules);
    rules.windows = true;
    const Cover windows = cover(block, rules);
    EXPECT_GT(windows.counts.leaves, 2 * ladder.counts.leaves);
    EXPECT_LT(median_radius(leaves_of(windows)), median_radius(leaves_of(ladder)));
    EXPECT_LE(uncovered(block, windows, rules.noise_variance),
              windows.counts.unexplained + windows.counts.isolated);
    const ThreadLimit limit(2);
    expect_same(windows, cover(block, rules));
}

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
        ASSERT_NEAR(s.surfel.polynomial.a[0], 0, 1e-9);  // through its own sheet, not between the two
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
    // 60 points of a thin pole above a plane: a ball that holds enough of them for a fit is 0.15 in radius.
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
    EXPECT_GT(c.counts.forced, 10u);
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
    EXPECT_NEAR(static_cast<double>(b.counts.leaves) / static_cast<double>(a.counts.leaves), 1, 0.1);
    EXPECT_LE(uncovered(all, b, rules.noise_variance), b.counts.unexplained + b.counts.isolated);
}

TEST(LevelCover, OwnsLimitsCentresAndWhatMustBeCovered) {
    const PointBlock block = block_of(sampled("sphere", 10000));
    CoverRules rules = rules_for(block);
    rules.owns = [](const Vec3d& p) { return p.x < 0; };
    const Cover c = cover(block, rules);
    for (const FittedSurfel& s : c.surfels) EXPECT_LT(s.surfel.center.x, 0);
    EXPECT_GT(c.counts.leaves, 10u);
    const PointBlock owned = block_of(filtered(sampled("sphere", 10000), [](const Vec3d& p) {
        return p.x < -0.3;
    }));
    EXPECT_EQ(uncovered(owned, c, rules.noise_variance), 0u);
}

TEST(LevelCover, CoarseThenFineLevelsCoverWhatAllWouldCover) {
    const PointBlock block = block_of(sampled("sculpture", 20000));
    const CoverRules rules = rules_for(block, 0.005);
    const Cover whole = cover(block, rules);
    CoverRules coarse = rules, fine = rules;
    coarse.last_level = 3;
    const Cover first = cover(block, coarse);
    fine.first_level = 4;
    fine.done = source_of(first.surfels);
    const Cover second = cover(block, fine);
    for (const FittedSurfel& s : first.surfels) EXPECT_LE(s.level, 3);
    for (const FittedSurfel& s : second.surfels) EXPECT_GE(s.level, 4);
    const double split = static_cast<double>(first.counts.leaves + second.counts.leaves);
    EXPECT_NEAR(split / static_cast<double>(whole.counts.leaves), 1, 0.1);
    Cover both = first;
    both.surfels.insert(both.surfels.end(), second.surfels.begin(), second.surfels.end());
    EXPECT_LE(uncovered(block, both, rules.noise_variance),
              second.counts.unexplained + second.counts.isolated);
}

/// Points that are centres of leaves.
std::set<std::uint64_t> leaf_set(const std::vector<FittedSurfel>& surfels) {
    std::set<std::uint64_t> out;
    for (const FittedSurfel& s : surfels)
        if (s.flags & kLeaf) out.insert(s.point_id);
    return out;
}

TEST(LevelCover, SlabsWithHalosGiveTheLeavesOfTheWhole) {
    const PointBlock block = block_of(sampled("sculpture", 60000));
    CoverRules rules = rules_for(block, 0.005);
    rules.spacing = 0.015;
    const auto whole = leaf_set(cover(block, rules).surfels);
    constexpr int kFirstFine = 4, kRungs = 2;
    const double halo = level_radius(rules.diagonal, kFirstFine - kRungs);
    CoverRules coarse = rules;
    coarse.last_level = kFirstFine;
    coarse.provisional = halo;
    const Cover first = cover(block, coarse);
    std::vector<FittedSurfel> all = first.surfels;
    const double walls[] = {-INFINITY, -0.4, 0.4, INFINITY};
    for (std::size_t k = 0; k < 3; ++k) {
        const double lo = walls[k], hi = walls[k + 1];
        PointBlock slab;
        for (std::size_t i = 0; i < block.size(); ++i) {
            if (block.position[i].x < lo - halo || block.position[i].x > hi + halo) continue;
            slab.position.push_back(block.position[i]);
            slab.normal.push_back(block.normal[i]);
            slab.id.push_back(block.id[i]);
        }
        CoverRules fine = rules;
        fine.first_level = kFirstFine;
        fine.rungs_above = kRungs;
        fine.done = source_of(first.surfels);
        fine.dropped = first.dropped;
        fine.owns = [=](const Vec3d& p) { return p.x >= lo && p.x < hi; };
        const Cover c = cover(slab, fine);
        all.insert(all.end(), c.surfels.begin(), c.surfels.end());
    }
    ASSERT_GT(whole.size(), 300u);
    ASSERT_LT(first.counts.leaves, whole.size() * 3 / 4) << "the slabs must have something to do";
    const auto sliced = leaf_set(all);
    std::vector<std::uint64_t> common;
    std::set_intersection(whole.begin(), whole.end(), sliced.begin(), sliced.end(),
                          std::back_inserter(common));
    EXPECT_NEAR(static_cast<double>(sliced.size()) / static_cast<double>(whole.size()), 1, 0.005);
    EXPECT_GT(common.size() * 100, whole.size() * 98);
}

/// Points on the faces of the unit cube, on a grid of `n` a side; those on edges and corners have the mean
/// normal of their faces, as a mesh's vertices.
PointBlock cube_points(int n) {
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (int x = 0; x <= n; ++x)
        for (int y = 0; y <= n; ++y)
            for (int z = 0; z <= n; ++z) {
                const int at[3] = {x, y, z};
                Vec3d normal;
                for (std::size_t axis = 0; axis < 3; ++axis)
                    normal[axis] = at[axis] == 0 ? -1 : at[axis] == n ? 1 : 0;
                if (!(sq_length(normal) > 0)) continue;
                positions.push_back({double(x) / n, double(y) / n, double(z) / n});
                normals.push_back(to_float(normalized(normal)));
            }
    return block_of(std::move(positions), std::move(normals));
}

/// Largest distance of a place on the cube's edges, off the grid, to the joined function of a leaf that holds
/// it in its core; infinite if none does.
double worst_on_edges(const std::vector<FittedSurfel>& leaves) {
    double worst = 0;
    for (double t = 0.0071; t < 1; t += 0.0173)
        for (const Vec3d& p : {Vec3d{t, 0, 0}, Vec3d{1, t, 0}, Vec3d{0, 1, t}, Vec3d{1, 1, t}}) {
            double best = INFINITY;
            for (const FittedSurfel& f : leaves) {
                const Vec3d x = (p - f.surfel.center) / f.surfel.support_radius;
                if (sq_length(x) < kTrim * kTrim)
                    best = std::min(best, std::abs(f.surfel.value(x)) * f.surfel.support_radius);
            }
            worst = std::max(worst, best);
        }
    return worst;
}

TEST(LevelCover, ACubeWithSharpEdgesIsExactAndTakesFewerLeaves) {
    const PointBlock block = cube_points(24);
    CoverRules rules = rules_for(block, 0.01);
    const Cover smooth = cover(block, rules);
    EXPECT_EQ(smooth.counts.sharp_edges + smooth.counts.sharp_corners, 0u);
    EXPECT_EQ(smooth.counts.sharp_rungs, 0u);
    rules.sharp = true;
    const Cover sharp = cover(block, rules);
    EXPECT_LT(sharp.counts.leaves * 10, smooth.counts.leaves * 8);
    EXPECT_GE(sharp.counts.sharp_corners, 8u);
    EXPECT_GE(sharp.counts.sharp_edges, 12u);
    EXPECT_EQ(sharp.counts.unexplained + sharp.counts.isolated, 0u);
    EXPECT_LT(worst_on_edges(leaves_of(sharp)), 1e-6);
    for (const FittedSurfel& leaf : leaves_of(sharp)) {
        if (leaf.surfel.n_sheets() < 2) continue;
        EXPECT_EQ(leaf.surfel.sharp->outer, Join::max) << "all edges of a cube are convex";
        EXPECT_LT(leaf.fit_error, 1e-7);
    }
}

TEST(LevelCover, SharpLeavesAreTheSameForAnyNumberOfThreads) {
    const PointBlock block = cube_points(16);
    CoverRules rules = rules_for(block, 0.01);
    rules.sharp = true;
    std::vector<Cover> covers;
    for (const int threads : {1, 2, 7}) {
        const ThreadLimit limit(threads);
        covers.push_back(cover(block, rules));
    }
    for (std::size_t i = 1; i < 3; ++i) {
        expect_same(covers[0], covers[i]);
        for (std::size_t k = 0; k < covers[0].surfels.size(); ++k) {
            const Surfel &a = covers[0].surfels[k].surfel, &b = covers[i].surfels[k].surfel;
            ASSERT_EQ(a.n_sheets(), b.n_sheets());
            for (std::size_t s = 0; s < a.n_sheets(); ++s)
                ASSERT_EQ(a.sheet_polynomial(s).a, b.sheet_polynomial(s).a);
        }
    }
}

TEST(LevelCover, ASmoothSurfaceHasNoSharpLeaves) {
    for (const char* shape : {"sphere", "torus"}) {
        const PointBlock block = block_of(sampled(shape, 6000));
        CoverRules rules = rules_for(block);
        const Cover smooth = cover(block, rules);
        rules.sharp = true;
        const Cover sharp = cover(block, rules);
        ASSERT_EQ(smooth.surfels.size(), sharp.surfels.size());
        for (std::size_t i = 0; i < smooth.surfels.size(); ++i) {
            ASSERT_TRUE(same(smooth.surfels[i], sharp.surfels[i])) << i;
            ASSERT_FALSE(sharp.surfels[i].surfel.sharp);
        }
    }
}

TEST(LevelCover, AFewPointsMakeAFewDiscs) {
    for (const std::size_t n : {3u, 5u, 9u, 30u}) {
        SCOPED_TRACE(n);
        const PointBlock block = graph_points(n, 1, 7, [](double u, double v) { return 0.1 * u * v; });
        const Cover c = cover(block, rules_for(block));
        EXPECT_GE(c.counts.leaves + c.counts.isolated + c.counts.unexplained, 1u);
        EXPECT_LE(c.counts.leaves, n);
        for (const FittedSurfel& s : c.surfels) {
            EXPECT_TRUE(std::isfinite(s.fit_error));
            for (const double a : s.surfel.polynomial.a) EXPECT_TRUE(std::isfinite(a));
        }
    }
}

TEST(LevelCover, Row34BothExtremesOfTheThresholdEnd) {
    const PointBlock block = block_of(sampled("bumpy", 20000));
    CoverRules rules = rules_for(block, 1e-9);
    const Cover finest = cover(block, rules);
    rules.mdl_threshold = 10;
    const Cover coarsest = cover(block, rules);
    EXPECT_EQ(coarsest.counts.saturated, coarsest.counts.leaves);
    EXPECT_NEAR(median_radius(leaves_of(coarsest)), rules.diagonal / 10, 1e-6);
    EXPECT_LT(median_radius(leaves_of(finest)), rules.diagonal / 40);
    EXPECT_EQ(finest.counts.saturated, 0u);
    EXPECT_GT(finest.counts.leaves, 5 * coarsest.counts.leaves);
}

}  // namespace
}  // namespace slim::test
