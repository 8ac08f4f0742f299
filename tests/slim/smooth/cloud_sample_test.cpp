#include "slim/smooth/cloud_sample.h"

#include "slim/neighbors/point_pyramid.h"
#include "slim/smooth/refit_budget.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace slim {
namespace {

constexpr std::uint64_t kSeed = 7;

CloudSample sampled(std::size_t n, std::size_t chunk, std::size_t most) {
    CloudSampler sampler(most, kSeed);
    for (std::size_t first = 0; first < n; first += chunk) {
        std::vector<Vec3d> p;
        std::vector<Vec3f> normals;
        for (std::size_t i = first; i < std::min(n, first + chunk); ++i) {
            p.push_back({static_cast<double>(i), 1, 2});
            normals.push_back({0, 0, i == 3 ? 0.0f : 2.0f});
        }
        sampler.add(p, normals, {0, 1, 0});
    }
    return sampler.take();
}

TEST(CloudSample, HoldsASmallCloudWhole) {
    const CloudSample s = sampled(1000, 300, 1000);
    EXPECT_EQ(s.share, 1);
    ASSERT_EQ(s.points.size(), 1000u);
    EXPECT_EQ(s.points.position[17], (Vec3d{17, 0, 2}));
    EXPECT_EQ(s.points.normal[17], (Vec3f{0, 0, 1}));
    EXPECT_EQ(s.points.normal[3], (Vec3f{}));
}

TEST(CloudSample, ThinsALargeOneToAShareThatChunksDoNotChange) {
    const CloudSample s = sampled(10000, 300, 1000), other = sampled(10000, 4000, 1000);
    EXPECT_EQ(s.points.id, other.points.id);
    EXPECT_EQ(s.points.position, other.points.position);
    EXPECT_LE(s.points.size(), 1000u);
    // Whether a half is few enough is known point by point, to a few in a hundred.
    EXPECT_NEAR(static_cast<double>(s.points.size()), s.share * 10000, 150);
    EXPECT_LE(s.share, 1.0 / 8);
    for (std::size_t i = 0; i < s.points.size(); ++i) {
        ASSERT_TRUE(in_share(kSeed, s.points.id[i], s.share));
        ASSERT_EQ(s.points.position[i].x, static_cast<double>(s.points.id[i]));
        ASSERT_EQ(s.points.normal[i], (Vec3f{0, 0, 1}));
    }
    std::size_t n = 0;
    for (std::uint64_t id = 0; id < 10000; ++id) n += in_share(kSeed, id, s.share) ? 1 : 0;
    EXPECT_EQ(s.points.size(), n);
}

TEST(CloudSample, LeavesOutWhatIsNotFiniteButCountsIt) {
    CloudSampler sampler(10, kSeed);
    sampler.add(std::vector<Vec3d>{{0, 0, 0}, {NAN, 0, 0}, {2, 0, 0}}, {}, {});
    const CloudSample s = sampler.take();
    EXPECT_EQ(s.points.id, (std::vector<std::uint64_t>{0, 2}));
    EXPECT_FALSE(s.points.has_normals());
}

TEST(RefitBudget, DividesWhatTheModelLeaves) {
    const RefitBudget usual = refit_budget(std::uint64_t{1} << 30, 15000),
                      small = refit_budget(kLeastSmoothMemory, 15000);
    EXPECT_GT(usual.points, 3500000u);
    EXPECT_LT(small.points, usual.points / 20);
    EXPECT_GT(small.points, 50000u);
    EXPECT_GT(small.leaves, 5000u);
    EXPECT_LT(small.fits, usual.fits / 10);
    const RefitBudget none = refit_budget(kLeastSmoothMemory, 1000000);
    EXPECT_EQ(none.points, 0u);
    EXPECT_EQ(none.leaves, 0u);
    EXPECT_LE(refit_budget(std::uint64_t{1} << 40, 10).points, std::size_t{1} << 22);
    // happy_stand_raw's are all fitted anew; of more the points leave them what they need.
    EXPECT_GE(refit_budget(kLeastSmoothMemory, 10911).leaves, 10911u);
    const RefitBudget many = refit_budget(kLeastSmoothMemory, 16000);
    EXPECT_GE(many.leaves, 16000u);
    EXPECT_LT(many.points, refit_budget(kLeastSmoothMemory, 10911).points);
    // Where that is too much, the points keep their half: they tell how noisy they are.
    const RefitBudget most = refit_budget(kLeastSmoothMemory, 20000);
    EXPECT_LT(most.leaves, 20000u);
    EXPECT_GT(most.points, many.points);
    // Batches lie where the points were.
    EXPECT_EQ(usual.batch, std::size_t{1} << 20);
    EXPECT_EQ(small.batch, std::size_t{1} << 16);
    const RefitBudget middle = refit_budget(std::uint64_t{1} << 28, 15000);
    EXPECT_LE(middle.batch * 480, middle.points * 130);
}

}  // namespace
}  // namespace slim
