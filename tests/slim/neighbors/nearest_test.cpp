#include "slim/neighbors/nearest.h"

#include "slim/base/parallel.h"
#include "tests/slim/neighbors/neighbors_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace slim::test {
namespace {

/// Squared distances of the k nearest places, by brute force.
std::vector<double> brute_place_distances(const PointBlock& block, const Vec3d& q, std::size_t k) {
    std::vector<Vec3d> places = block.position;
    const auto less = [](const Vec3d& a, const Vec3d& b) {
        return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
    };
    std::sort(places.begin(), places.end(), less);
    places.erase(std::unique(places.begin(), places.end()), places.end());
    PointBlock distinct;
    distinct.position = places;
    return brute_distances(distinct, q, k);
}

/// Every wanted point's neighbours against brute force.
void expect_nearest(const PointBlock& block, const std::vector<std::uint32_t>& wanted,
                    std::size_t k) {
    const NearestSearch search(block.position);
    std::vector<std::vector<std::uint32_t>> found(wanted.size());
    search.for_each(wanted, k, [&](std::size_t w, std::span<const std::uint32_t> neighbors) {
        EXPECT_TRUE(found[w].empty()) << "visited twice";
        found[w].assign(neighbors.begin(), neighbors.end());
    });
    for (std::size_t w = 0; w < wanted.size(); ++w) {
        const Vec3d& q = block.position[wanted[w]];
        std::vector<double> distances;
        for (const std::uint32_t j : found[w]) {
            EXPECT_FALSE(search.is_repeat(j));
            distances.push_back(sq_length(block.position[j] - q));
        }
        std::sort(distances.begin(), distances.end());
        const std::vector<double> expected = brute_place_distances(block, q, k);
        ASSERT_EQ(distances.size(), expected.size());
        for (std::size_t j = 0; j < expected.size(); ++j)
            ASSERT_NEAR(distances[j], expected[j], 1e-14 * expected[j]);
        EXPECT_EQ(std::set(found[w].begin(), found[w].end()).size(), found[w].size());
    }
}

std::vector<std::uint32_t> every(const PointBlock& block, std::size_t step) {
    std::vector<std::uint32_t> wanted;
    for (std::size_t i = 0; i < block.size(); i += step)
        wanted.push_back(static_cast<std::uint32_t>(i));
    return wanted;
}

TEST(NearestSearch, FindsTheNearestDistinctPlacesOfHardClouds) {
    for (const PointBlock& raw : hard_blocks()) {
        const PointBlock block = along_curve(raw);
        for (const std::size_t k : {1u, 10u, 40u}) {
            SCOPED_TRACE(testing::Message() << block.size() << " points, k " << k);
            expect_nearest(block, every(block, block.size() > 1000 ? 7 : 1), k);
        }
    }
}

TEST(NearestSearch, IsExactOnSurfacesWithStraysRepeatsAndFarFromTheOrigin) {
    PointBlock block = block_of(sampled("sphere", 3000));
    for (std::size_t i = 0; i < 300; ++i) block.position[i] = random_in_cube(31, i) * 30.0;
    for (std::size_t i = 300; i < 1500; ++i) block.position[i] = block.position[300 + i % 100];
    for (Vec3d& p : block.position) p = p * 0x1p-4 + Vec3d{403000, 3604900, 1000};
    block = along_curve(block);
    expect_nearest(block, every(block, 1), 16);
    expect_nearest(block, every(block, 11), 80);
}

TEST(NearestSearch, TakesTheLowerIndexOfTwoAsFar) {
    // A grid: four neighbours at one distance, k takes two of them.
    PointBlock block;
    for (int i = 0; i < 400; ++i) block.position.push_back({double(i % 20), double(i / 20), 0});
    block.id.resize(block.size());
    block.normal.resize(block.size());
    block = along_curve(block);
    const NearestSearch search(block.position);
    search.for_each(every(block, 1), 3, [&](std::size_t w, std::span<const std::uint32_t> found) {
        std::vector<std::pair<double, std::uint32_t>> all;
        for (std::uint32_t i = 0; i < block.size(); ++i)
            all.emplace_back(sq_length(block.position[i] - block.position[w]), i);
        std::sort(all.begin(), all.end());
        std::set<std::uint32_t> expected{all[0].second, all[1].second, all[2].second};
        EXPECT_EQ(std::set(found.begin(), found.end()), expected);
    });
}

TEST(NearestSearch, AnswersTheSameForAnyNumberOfThreads) {
    const PointBlock block = along_curve(random_cube(20000, 10));
    std::vector<std::vector<std::uint32_t>> answers;
    for (const int n : {1, 2, 7}) {
        const ThreadLimit limit(n);
        std::vector<std::uint32_t> all(block.size() * 12);
        NearestSearch(block.position)
            .for_each(every(block, 1), 12,
                      [&](std::size_t w, std::span<const std::uint32_t> found) {
                          std::copy(found.begin(), found.end(),
                                    all.begin() + static_cast<std::ptrdiff_t>(w * 12));
                      });
        answers.push_back(all);
    }
    EXPECT_EQ(answers[0], answers[1]);
    EXPECT_EQ(answers[0], answers[2]);
}

}  // namespace
}  // namespace slim::test
