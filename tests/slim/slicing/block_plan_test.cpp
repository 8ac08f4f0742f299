#include "slim/slicing/block_plan.h"

#include "slim/base/hash.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace slim {
namespace {

double random(std::uint64_t seed, std::size_t i, std::uint64_t axis) {
    return unit_interval(keyed_hash(seed, 3 * i + axis));
}

/// Points on a square base and a thin column on it: flat in two directions, long in the third.
std::vector<Vec3d> column_on_a_base(std::uint64_t seed, std::size_t n, double scale, double shift) {
    std::vector<Vec3d> points;
    for (std::size_t i = 0; i < n; ++i) {
        const double u = random(seed, i, 0), v = random(seed, i, 1), w = random(seed, i, 2);
        const Vec3d p =
            i % 2 == 0 ? Vec3d{u, v, 0} : Vec3d{0.5 + 0.1 * std::cos(7 * u), 0.5, 3 * w * w};
        points.push_back(p * scale + Vec3d{shift, -shift, shift});
    }
    return points;
}

CellCounts counts_of(const std::vector<Vec3d>& points) {
    Bbox first;
    first.extend(points[0]);
    CellCounts counts(first);
    for (const Vec3d& p : points) counts.add(p);
    return counts;
}

std::uint64_t sum(const std::vector<std::uint64_t>& values) {
    return std::accumulate(values.begin(), values.end(), std::uint64_t{0});
}

/// The plan's counts, its splits and its regions must say the same of the points.
void expect_exact(const BlockPlan& plan, const std::vector<Vec3d>& points) {
    std::vector<std::uint64_t> counted(plan.n_blocks());
    for (const Vec3d& p : points) {
        const std::size_t block = plan.block_of(p);
        ++counted[block];
        for (std::size_t b = 0; b < plan.n_blocks(); ++b)
            ASSERT_EQ(is_in(plan.regions[b], p), b == block);
    }
    EXPECT_EQ(counted, plan.n_points);
    EXPECT_EQ(std::count(counted.begin(), counted.end(), 0u), 0);
}

TEST(CellCounts, CountsEveryPointInItsCellWhateverTheOrder) {
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
        SCOPED_TRACE(seed);
        const double scale = std::pow(10.0, 2 * static_cast<double>(seed) - 10);
        std::vector<Vec3d> points = column_on_a_base(seed, 500, scale, seed % 3 == 0 ? 4e5 : 0);
        const CellCounts counts = counts_of(points);
        const double w = counts.width();
        std::uint64_t total = 0;
        for (const Cell& c : counts.cells()) {
            const auto inside = std::count_if(points.begin(), points.end(), [&](const Vec3d& p) {
                bool in = true;
                for (std::size_t a = 0; a < 3; ++a)
                    in &= p[a] >= static_cast<double>(c.at[a]) * w &&
                          p[a] < static_cast<double>(c.at[a] + 1) * w;
                return in;
            });
            ASSERT_EQ(static_cast<std::uint64_t>(inside), c.n_points);
            total += c.n_points;
        }
        EXPECT_EQ(total, points.size());
    }
}

TEST(CellCounts, ManyPointsMergeCellsAndTheOrderDoesNotMatter) {
    std::vector<Vec3d> points = column_on_a_base(1, 600000, 1, 0);
    const CellCounts a = counts_of(points);
    std::reverse(points.begin(), points.end());
    const CellCounts b = counts_of(points);
    EXPECT_EQ(a.width(), b.width());
    const auto of_a = a.cells(), of_b = b.cells();
    EXPECT_LE(of_a.size(), CellCounts::kMostCells);
    EXPECT_GT(of_a.size(), CellCounts::kMostCells / 8);
    ASSERT_EQ(of_a.size(), of_b.size());
    for (std::size_t i = 0; i < of_a.size(); ++i) {
        ASSERT_EQ(of_a[i].at, of_b[i].at);
        ASSERT_EQ(of_a[i].n_points, of_b[i].n_points);
    }
}

TEST(CellCounts, SurvivesExtremeValues) {
    const std::vector<double> values{0,       1e-300, -1e300, 1.5e308, -1.5e308,
                                     5e-324, -1e-12, 1e6,    -7};
    std::vector<Vec3d> points;
    for (const double x : values)
        for (const double y : values) points.push_back({x, y, -x});
    std::uint64_t total = 0;
    for (const Cell& c : counts_of(points).cells()) total += c.n_points;
    EXPECT_EQ(total, points.size());
}

TEST(SurfaceSpacing, IsThatOfASquareAndOfASphere) {
    std::vector<Vec3d> square, sphere;
    for (std::size_t i = 0; i < 200000; ++i) {
        square.push_back({random(1, i, 0), random(1, i, 1), 0.3 * random(1, i, 0)});
        const double z = 2 * random(2, i, 0) - 1, a = 6.283185307 * random(2, i, 1);
        sphere.push_back(
            {std::sqrt(1 - z * z) * std::cos(a), std::sqrt(1 - z * z) * std::sin(a), z});
    }
    const auto spacing = [](const std::vector<Vec3d>& points) {
        const CellCounts counts = counts_of(points);
        return surface_spacing(counts.cells(), counts.width());
    };
    // The factor is right on average over slopes: 1 to 1.73 cells meet a plane.
    EXPECT_NEAR(spacing(square) / std::sqrt(std::hypot(1, 0.3) / 200000), 1, 0.2);
    EXPECT_NEAR(spacing(sphere) / std::sqrt(4 * 3.14159265 / 200000), 1, 0.1);
}

TEST(BlockPlan, BlocksHoldNearlyEqualCountsThatAreExact) {
    for (std::uint64_t seed = 0; seed < 4; ++seed)
        for (const std::uint64_t wanted : {1u, 2u, 3u, 7u, 20u}) {
            SCOPED_TRACE(seed);
            const std::vector<Vec3d> points = column_on_a_base(seed, 40000, 3, 1000);
            const CellCounts counts = counts_of(points);
            const BlockPlan plan = plan_blocks(counts.cells(), counts.width(), wanted);
            ASSERT_EQ(plan.n_blocks(), wanted);
            expect_exact(plan, points);
            const double share = 40000.0 / static_cast<double>(wanted);
            // The layer of cells at the column's foot holds 440 points; each of three cuts may miss
            // by half of it.
            for (const std::uint64_t n : plan.n_points)
                EXPECT_NEAR(static_cast<double>(n), share, 0.06 * share + 660);
        }
}

TEST(BlockPlan, BlocksOfABaseAreAsThickAsTheyCanBe) {
    // In slabs across the base or the column's height, half of the points would stand in one bin.
    const std::vector<Vec3d> points = column_on_a_base(5, 100000, 1, 0);
    const CellCounts counts = counts_of(points);
    const BlockPlan plan = plan_blocks(counts.cells(), counts.width(), 16);
    for (const Bbox& r : plan.regions)
        for (std::size_t axis = 0; axis < 3; ++axis)
            EXPECT_GT(r.hi[axis] - r.lo[axis], 0.04);
}

TEST(BlockPlan, PointsInOnePlaceMakeOneBlock) {
    const std::vector<Vec3d> points(100, Vec3d{5, 5, 5});
    const CellCounts counts = counts_of(points);
    const BlockPlan plan = plan_blocks(counts.cells(), counts.width(), 4);
    EXPECT_EQ(plan.n_points, (std::vector<std::uint64_t>{100}));
    EXPECT_TRUE(plan.splits.empty());
    const std::vector<Vec3d> two{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {1, 0, 0}};
    const CellCounts of_two = counts_of(two);
    const BlockPlan pair = plan_blocks(of_two.cells(), of_two.width(), 4);
    EXPECT_EQ(pair.n_blocks(), 2u);
    expect_exact(pair, two);
}

TEST(BlockPlan, PointsWithinAHaloAreCountedAndAFewMore) {
    const std::vector<Vec3d> points = column_on_a_base(3, 50000, 1, 0);
    const CellCounts counts = counts_of(points);
    const auto cells = counts.cells();
    const BlockPlan plan = plan_blocks(cells, counts.width(), 6);
    const std::vector<double> halos{10, 0.2, 0.05, 0};
    const HaloCounts within = count_within(plan, cells, counts.width(), halos);
    for (std::size_t h = 0; h < halos.size(); ++h) {
        const auto fullest = [&](double halo) {
            std::uint64_t n = 0;
            for (const Bbox& r : plan.regions)
                n = std::max<std::uint64_t>(
                    n, static_cast<std::uint64_t>(std::count_if(
                           points.begin(), points.end(),
                           [&](const Vec3d& p) { return is_near(r, p, halo); })));
            return n;
        };
        EXPECT_GE(within.most[h], fullest(halos[h]));
        EXPECT_LE(within.most[h], fullest(halos[h] + 1.01 * counts.width()));
    }
    EXPECT_EQ(within.most[0], sum(plan.n_points));
    EXPECT_EQ(within.all[0], 6 * sum(plan.n_points));
    EXPECT_GT(within.all[2], sum(plan.n_points));
}

TEST(BlockPlan, MemoryDecidesHowManyPointsAreHeld) {
    EXPECT_EQ(points_in_memory(kProgramBytes + 500 * kBytesPerPoint), 500u);
    EXPECT_EQ(points_in_memory(1), 1u);
}

TEST(BlockPlan, TellsBoxesNearARegionFromThoseWhollyNear) {
    const Bbox region{{0, 0, 0}, {1, 1, INFINITY}};
    const Bbox inside{{0.2, 0.2, 5}, {0.4, 0.4, 6}}, across{{0.5, 0.5, 0}, {1.5, 0.6, 1}};
    const Bbox beside{{1.05, 0, 0}, {1.09, 1, 1}}, far{{3, 0, 0}, {4, 1, 1}};
    EXPECT_TRUE(comes_near(region, inside, 0) && is_near(region, inside, 0));
    EXPECT_TRUE(comes_near(region, across, 0.1) && !is_near(region, across, 0.1));
    EXPECT_TRUE(!comes_near(region, beside, 0) && is_near(region, beside, 0.1));
    EXPECT_FALSE(comes_near(region, far, 0.1));
}

}  // namespace
}  // namespace slim
