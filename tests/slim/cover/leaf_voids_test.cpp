#include "slim/cover/leaf_voids.h"

#include "slim/cover/drawn_part.h"
#include "slim/cover/leaf_rim.h"
#include "slim/cover/void_ends.h"
#include "tests/slim/cover/cover_support.h"
#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

namespace slim::test {
namespace {

using Keeps = std::function<bool(double x, double y)>;

double chance(std::uint64_t seed, std::uint64_t n) { return (random_at(seed, n) + 1) / 2; }

/// n random points of the square [-1, 1]^2 with noise, those that are kept.
PointBlock plane(std::size_t n, double noise, std::uint64_t seed, const Keeps& keeps) {
    std::vector<Vec3d> positions{{0, 0, 0}};
    std::vector<Vec3f> normals;
    for (std::size_t i = 0; i < n; ++i) {
        const double x = random_at(seed, 4 * i), y = random_at(seed, 4 * i + 1);
        // the sum of three numbers in [-1, 1] has a variance of 1
        const double z = random_at(seed, 4 * i + 2) + random_at(seed, 4 * i + 3) +
                         random_at(seed + 1, i);
        if (keeps(x, y)) positions.push_back({x, y, noise * z});
    }
    normals.assign(positions.size(), {0, 0, 1});
    return block_of(std::move(positions), std::move(normals));
}

struct Found {
    CoveringSurfel leaf;
    LeafVoids voids;
};

/// The leaf of radius 0.9 about the middle, and its voids.
Found voids_in(const PointBlock& block) {
    Found out;
    BallPoints<double> ball;
    out.leaf = fit_surfel(tree_of(block), {0, 0, 0}, {0, 0, 1}, 0.9, 2, false, 1e-8, ball);
    if (may_bridge(out.leaf)) out.voids = voids_of(out.leaf, ball, rims_of(out.leaf));
    return out;
}

TEST(LeafVoids, AHoleIsFoundAndTheLeafEndsBeforeIt) {
    // 5,000 points: spacing 0.028, the hole ten of them wide
    const double near = 0.2, far = 0.48, spacing = 2 / std::sqrt(5000.0);
    const auto block = plane(5000, 0.001, 3, [&](double x, double y) {
        return x < near || x > far || std::abs(y) > 0.14;
    });
    Found found = voids_in(block);
    ASSERT_TRUE(found.voids.any);
    ASSERT_EQ(found.voids.n_ends, 1u);
    EXPECT_NEAR(found.voids.ends[0].reach * 0.9, near, 2 * spacing);
    EXPECT_NEAR(found.voids.spacing * 0.9, spacing, 0.1 * spacing);

    double share = 0;
    const std::size_t before = found.leaf.covered.size();
    if (!end_at_voids(found.voids, 0, found.leaf, share)) {
        EXPECT_LT(share, 1);
        EXPECT_GT(share, 0.5);
        found.voids.ends[0].reach = 0.24;  // where a rim stands
        ASSERT_TRUE(end_at_voids(found.voids, 0, found.leaf, share));
    }
    const Rim rim = unpack_rim(rims_of(found.leaf).first);
    ASSERT_FALSE(rim.is_whole());
    EXPECT_GT(rim.u, 0.9);
    EXPECT_LT(found.leaf.covered.size(), before);
    EXPECT_GT(found.leaf.covered.size(), before / 3);
    for (const Covered& p : found.leaf.covered)
        EXPECT_LE(rim.u * static_cast<double>(p.u) + rim.v * static_cast<double>(p.v), rim.reach);
}

TEST(LeafVoids, WhatIsBeyondRimsIsNotCoveredAgain) {
    const auto block = plane(5000, 0.001, 3, [](double, double) { return true; });
    FittedSurfel f = voids_in(block).leaf.fitted;
    BallPoints<double> ball;
    const std::size_t whole = cover_again(tree_of(block), f, 1e-8, ball).covered.size();
    f.surfel.rims.first = pack_rim(0, 0.16);
    const auto covered = cover_again(tree_of(block), f, 1e-8, ball).covered;
    EXPECT_LT(covered.size(), whole);
    EXPECT_GT(covered.size(), whole / 2);
    for (const Covered& p : covered) EXPECT_LE(p.u, 0.1601f);
}

TEST(LeafVoids, ItsOwnPointStaysCovered) {
    const auto block = plane(5000, 0.001, 3, [&](double x, double y) {
        return x < 0.2 || x > 0.48 || std::abs(y) > 0.14;
    });
    Found found = voids_in(block);
    ASSERT_EQ(found.voids.n_ends, 1u);
    found.voids.ends[0].reach = 0.24;
    const auto beyond = std::find_if(found.leaf.covered.begin(), found.leaf.covered.end(),
                                     [](const Covered& p) { return p.in_core && p.u > 0.5f; });
    ASSERT_NE(beyond, found.leaf.covered.end());
    const std::size_t before = found.leaf.covered.size();
    double share = 0;
    EXPECT_FALSE(end_at_voids(found.voids, beyond->point, found.leaf, share));
    EXPECT_EQ(found.leaf.covered.size(), before);
    EXPECT_EQ(found.leaf.void_rims.first, 0);
}

TEST(LeafVoids, ChanceMakesNone) {
    for (std::uint64_t seed = 10; seed < 60; ++seed)
        for (const std::size_t n : {300u, 3000u}) {
            const Found found =
                voids_in(plane(n, 0.001, seed, [](double, double) { return true; }));
            ASSERT_FALSE(found.voids.any) << n << " " << seed;
        }
}

TEST(LeafVoids, ScanLinesAreNone) {
    for (const double ratio : {5.0, 10.0, 30.0})
        for (const double turned : {0.0, 0.4}) {
            SCOPED_TRACE(ratio);
            std::vector<Vec3d> positions{{0, 0, 0}};
            const double mean = 0.02, along = mean / std::sqrt(ratio), across = along * ratio;
            const double c = std::cos(turned), s = std::sin(turned);
            for (double y = -1.4; y < 1.4; y += across)
                for (double x = -1.4; x < 1.4; x += along)
                    positions.push_back({c * x - s * y, s * x + c * y, 0});
            std::vector<Vec3f> normals(positions.size(), {0, 0, 1});
            EXPECT_FALSE(voids_in(block_of(positions, normals)).voids.any);
        }
}

TEST(LeafVoids, DensityThatChangesIsNone) {
    for (std::uint64_t seed = 10; seed < 20; ++seed) {
        std::size_t i = 0;
        const auto thinned = [&](double share) { return chance(seed + 7, i++) < share; };
        // a tenth at the other side
        EXPECT_FALSE(voids_in(plane(20000, 0.001, seed, [&](double x, double) {
                         return thinned(std::pow(10, -0.5 * (x + 1)));
                     })).voids.any);
        // three hundredths beyond a line: its points stand alone
        EXPECT_FALSE(voids_in(plane(40000, 0.001, seed, [&](double x, double) {
                         return x < 0.1 || thinned(0.03);
                     })).voids.any);
    }
}

/// Places of a grid that some leaf draws, or that none does.
std::size_t count_drawn(const std::vector<FittedSurfel>& leaves, const Keeps& asked, bool drawn) {
    std::size_t n = 0;
    for (double x = -0.95; x < 0.96; x += 0.01)
        for (double y = -0.95; y < 0.96; y += 0.01) {
            if (!asked(x, y)) continue;
            const bool is_drawn =
                std::any_of(leaves.begin(), leaves.end(), [&](const FittedSurfel& f) {
                    return is_drawn_at(f.surfel, {x, y, 0}, {0, 0, 1});
                });
            n += is_drawn == drawn ? 1u : 0u;
        }
    return n;
}

TEST(LeafVoids, AHoleOfANoisyPlaneStaysOpenAndNothingElseOpens) {
    // 25 spacings wide; leaves are as large as they may be, 25 spacings, too
    const double half = 0.14, spacing = 2 / std::sqrt(32000.0);
    for (const double noise : {0.001, 0.004}) {
        SCOPED_TRACE(noise);
        for (const bool is_round : {false, true}) {
            const auto depth = [&](double x, double y) {  // inside of the hole
                x -= 0.2, y += 0.1;
                return is_round ? half - std::hypot(x, y)
                                : half - std::max(std::abs(x), std::abs(y));
            };
            const PointBlock block =
                plane(32000, noise, 5, [&](double x, double y) { return depth(x, y) < 0; });
            const CoverRules rules = rules_for(block, 0.01);
            const Cover c = cover(block, rules);
            const auto leaves = leaves_of(c);
            const auto inside = [&](double x, double y) { return depth(x, y) > 5 * spacing; };
            const auto outside = [&](double x, double y) { return depth(x, y) < -spacing; };
            EXPECT_EQ(count_drawn(leaves, inside, true), 0u);
            EXPECT_EQ(count_drawn(leaves, outside, false), 0u);
            EXPECT_LT(leaves.size(), 160u);
            EXPECT_LE(uncovered(block, c, rules.noise_variance),
                      c.counts.unexplained + c.counts.isolated);
        }
    }
}

TEST(LeafVoids, APlaneWithoutHolesIsDrawnAllOver) {
    std::size_t i = 0;
    const auto all = [](double, double) { return true; };
    const Keeps densities[] = {
        all, [&](double x, double) { return chance(9, i++) < std::pow(10, -0.5 * (x + 1)); }};
    for (const Keeps& keeps : densities) {
        const PointBlock block = plane(40000, 0.002, 6, keeps);
        EXPECT_EQ(count_drawn(leaves_of(cover(block, rules_for(block, 0.01))), all, false), 0u);
    }
}

}  // namespace
}  // namespace slim::test
