#include "pipeline/build/fit_division.h"

#include "slim/base/hash.h"
#include "slim/cover/cover_rules.h"
#include "slim/slicing/block_plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

namespace slim {
namespace {

/// A unit sphere of so many points, cut into so many slices.
SlicePlan sphere_plan(std::size_t n, std::uint64_t slices) {
    SlicePlan plan;
    plan.n_points = n;
    CellCounts counts(Bbox{{-1, -1, -1}, {1, 1, 1}});
    for (std::size_t i = 0; i < n; ++i) {
        const double z = 2 * unit_interval(keyed_hash(1, 2 * i)) - 1;
        const double a = 6.283185307 * unit_interval(keyed_hash(1, 2 * i + 1)),
                     r = std::sqrt(1 - z * z);
        const Vec3d p{r * std::cos(a), r * std::sin(a), z};
        plan.bounds.extend(p);
        counts.add(p);
    }
    plan.diagonal = plan.bounds.diagonal();
    plan.spacing = surface_spacing(counts.cells(), counts.width());
    const BlockPlan blocks = plan_blocks(counts.cells(), counts.width(), slices);
    for (std::size_t b = 0; b < blocks.n_blocks(); ++b)
        plan.slices.push_back({blocks.n_points[b], {}, blocks.regions[b]});
    const HaloCounts within =
        count_within(blocks, counts.cells(), counts.width(), possible_halos(plan.diagonal));
    plan.most_within = within.most;
    plan.all_within = within.all;
    return plan;
}

std::uint64_t memory_for(std::uint64_t points) { return kProgramBytes + points * kBytesPerPoint; }

TEST(FitDivision, OneSliceHasNoCoarseLevels) {
    SlicePlan plan;
    plan.n_points = 1000;
    plan.slices.resize(1);
    EXPECT_EQ(divide_fit(plan, memory_for(1000)).first_fine, 1);
}

TEST(FitDivision, WhereAllPointsFitAllAreTheSample) {
    const SlicePlan plan = sphere_plan(100000, 4);
    const FitDivision d = divide_fit(plan, memory_for(100000));
    EXPECT_EQ(d.share, 1);
    EXPECT_TRUE(halo_suffices(plan, d));
    EXPECT_LT(d.halo, 0.2 * plan.diagonal);
    EXPECT_EQ(d.last_coarse, d.first_fine);
    EXPECT_DOUBLE_EQ(d.halo, level_radius(plan.diagonal, d.first_fine - kHaloRungs));
}

TEST(FitDivision, SampleAndFullestSliceFitAndTheHaloIsAsWideAsTheSampleNeeds) {
    const SlicePlan plan = sphere_plan(400000, 12);
    for (const std::uint64_t held : {200000, 150000}) {
        SCOPED_TRACE(held);
        const FitDivision d = divide_fit(plan, memory_for(held));
        EXPECT_LE(d.share * 400000, static_cast<double>(held) * 1.001);
        EXPECT_LE(plan.most_within[static_cast<std::size_t>(d.first_fine - 1)], held);
        EXPECT_GE(d.halo, 26 * plan.spacing / std::sqrt(d.share));
        EXPECT_TRUE(halo_suffices(plan, d));
        // A smaller sample was taken because that reads fewer points, or none was.
        FitDivision largest = d;
        largest.share = static_cast<double>(held) / 400000;
        EXPECT_LE(points_read(plan, d), points_read(plan, largest));
    }
}

TEST(FitDivision, LittleMemoryNarrowsTheHaloAndEndsTheCoarseLevelsWhereTheSampleDoes) {
    SlicePlan plan = sphere_plan(400000, 40);
    const FitDivision d = divide_fit(plan, memory_for(30000));
    EXPECT_LE(points_held(plan, d), 30000u);
    EXPECT_GE(d.halo, 12 * plan.spacing);
    EXPECT_FALSE(halo_suffices(plan, d));
    EXPECT_LT(d.last_coarse, d.first_fine);
    EXPECT_LE(level_radius(plan.diagonal, d.last_coarse), 10 * plan.spacing / std::sqrt(d.share));
    // Never so narrow that a fit cannot do with it; whatever it takes where the slices were asked
    // for.
    EXPECT_GE(divide_fit(plan, memory_for(5000)).halo, 12 * plan.spacing);
    plan.slices_given = true;
    EXPECT_TRUE(halo_suffices(plan, divide_fit(plan, memory_for(30000))));
}

}  // namespace
}  // namespace slim
