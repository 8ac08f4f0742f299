#include "slim/slicing/slab_plan.h"

#include "slim/base/hash.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace slim {
namespace {

std::vector<double> random_values(std::uint64_t seed, std::size_t n, double scale, double shift) {
    std::vector<double> values(n);
    for (std::size_t i = 0; i < n; ++i)
        values[i] = shift + scale * std::pow(unit_interval(keyed_hash(seed, i)), 2);
    return values;
}

AxisHistogram histogram_of(const std::vector<double>& values) {
    AxisHistogram histogram(values[0], values[0]);
    for (const double value : values) histogram.add(value);
    return histogram;
}

/// The plan's counts, and its cuts applied to the values, must say the same.
void expect_exact(const SlabPlan& plan, const std::vector<double>& values) {
    std::vector<std::uint64_t> counted(plan.n_slabs());
    for (const double value : values) ++counted[slab_of(value, plan.cuts)];
    EXPECT_EQ(counted, plan.n_points);
    EXPECT_TRUE(std::is_sorted(plan.cuts.begin(), plan.cuts.end()));
    EXPECT_EQ(std::count(counted.begin(), counted.end(), 0u), 0);
}

TEST(AxisHistogram, CountsEveryValueInItsBinWhateverTheOrder) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        SCOPED_TRACE(seed);
        const double scale = std::pow(10.0, static_cast<double>(seed) - 10);
        std::vector<double> values = random_values(seed, 500, scale, seed % 3 == 0 ? 4e5 : -scale / 2);
        AxisHistogram histogram = histogram_of(values);
        const auto& counts = histogram.counts();
        for (std::size_t k = 0; k < counts.size(); ++k) {
            const auto inside = std::count_if(values.begin(), values.end(), [&](double v) {
                return v >= histogram.edge(k) && v < histogram.edge(k + 1);
            });
            ASSERT_EQ(static_cast<std::uint64_t>(inside), counts[k]) << k;
        }
        EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), std::uint64_t{0}), values.size());
    }
}

TEST(AxisHistogram, SurvivesExtremeValues) {
    const std::vector<double> values{0,      1e-300, -1e300, 1.5e308, -1.5e308, 5e-324,
                                     -1e-12, 1e6,    1e6,    -7};
    const AxisHistogram histogram = histogram_of(values);
    const auto& counts = histogram.counts();
    EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), std::uint64_t{0}), values.size());
}

TEST(SlabPlan, SlabsHoldNearlyEqualCountsThatAreExact) {
    for (std::uint64_t seed = 0; seed < 10; ++seed)
        for (const std::uint64_t wanted : {1u, 2u, 4u, 7u}) {
            SCOPED_TRACE(seed);
            const std::vector<double> values = random_values(seed, 40000, 3, 1000);
            const SlabPlan plan = plan_slabs(histogram_of(values), wanted);
            ASSERT_EQ(plan.n_slabs(), wanted);
            expect_exact(plan, values);
            const double share = 40000.0 / static_cast<double>(wanted);
            // The first bins hold many points each: x = u^2 has density 1/(2 sqrt x).
            for (const std::uint64_t n : plan.n_points)
                EXPECT_NEAR(static_cast<double>(n), share, 0.06 * share + 600);
        }
}

TEST(SlabPlan, PointsInOnePlaceMakeOneSlab) {
    const std::vector<double> values(100, 5.0);
    const SlabPlan plan = plan_slabs(histogram_of(values), 4);
    EXPECT_EQ(plan.n_points, (std::vector<std::uint64_t>{100}));
    EXPECT_TRUE(plan.cuts.empty());
    const std::vector<double> two{0, 0, 0, 1, 1, 1};
    expect_exact(plan_slabs(histogram_of(two), 4), two);
}

TEST(SlabPlan, MemoryDecidesTheNumberOfSlabs) {
    EXPECT_EQ(slabs_for_memory(1000, std::uint64_t{1} << 30), 1u);
    // A slab may hold half of the points that fit: its halo is up to half of it on either side.
    EXPECT_EQ(points_in_memory(kProgramBytes + 500 * kBytesPerPoint), 500u);
    EXPECT_EQ(slabs_for_memory(500, kProgramBytes + 500 * kBytesPerPoint), 1u);
    EXPECT_EQ(slabs_for_memory(1000, kProgramBytes + 500 * kBytesPerPoint), 4u);
    EXPECT_EQ(slabs_for_memory(1000000, 1), kMostSlabs);
    EXPECT_EQ(slabs_for_memory(0, 1), 1u);
}

}  // namespace
}  // namespace slim
