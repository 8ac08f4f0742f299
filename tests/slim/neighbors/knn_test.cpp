#include "slim/neighbors/knn.h"

#include "slim/base/parallel.h"
#include "tests/slim/neighbors/neighbors_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace slim::test {
namespace {

TEST(KnnIndex, FindsTheNearestAtTheirDistances) {
    for (const PointBlock& block : hard_blocks()) {
        SCOPED_TRACE(block.size());
        const KnnIndex index(block.position);
        ASSERT_EQ(index.size(), block.size());
        std::vector<Vec3d> queries;
        for (std::uint64_t q = 0; q < 100; ++q)
            queries.push_back(q % 2 ? random_in_cube(96, q) * 2.0
                                    : block.position[q % block.size()]);
        std::vector<std::uint32_t> found;
        std::vector<double> sq_distances;
        const std::size_t k = index.search(queries, 20, found, sq_distances);
        ASSERT_EQ(k, std::min<std::size_t>(20, block.size()));
        for (std::size_t q = 0; q < queries.size(); ++q) {
            const std::vector<double> expected = brute_distances(block, queries[q], k);
            for (std::size_t j = 0; j < k; ++j) {
                ASSERT_NEAR(sq_distances[q * k + j], expected[j], 1e-14);
                ASSERT_NEAR(sq_length(block.position[found[q * k + j]] - queries[q]), expected[j],
                            1e-14);
            }
        }
    }
}

TEST(KnnIndex, IsExactFarFromTheOriginToo) {
    PointBlock block = random_cube(3000, 9);
    for (Vec3d& p : block.position) p += Vec3d{403000, 3604900, 1000};
    const KnnIndex index(block.position);
    std::vector<std::uint32_t> found;
    std::vector<double> sq_distances;
    const std::vector<Vec3d> queries(block.position.begin(), block.position.begin() + 200);
    index.search(queries, 16, found, sq_distances);
    for (std::size_t q = 0; q < queries.size(); ++q) {
        const std::vector<double> expected = brute_distances(block, queries[q], 16);
        for (std::size_t j = 0; j < 16; ++j) 
            ASSERT_NEAR(sq_distances[q * 16 + j], expected[j], 1e-14 * expected[j]);
    }
}

TEST(KnnIndex, AnswersTheSameForAnyNumberOfThreads) {
    const PointBlock block = random_cube(20000, 10);
    const KnnIndex index(block.position);
    std::vector<std::uint32_t> one, seven;
    std::vector<double> d_one, d_seven;
    {
        const ThreadLimit limit(1);
        index.search(block.position, 8, one, d_one);
    }
    const ThreadLimit limit(7);
    index.search(block.position, 8, seven, d_seven);
    EXPECT_EQ(one, seven);
    EXPECT_EQ(d_one, d_seven);
}

TEST(KnnIndex, OfNoPointsAnswersZero) {
    const KnnIndex index({});
    std::vector<std::uint32_t> found{1};
    std::vector<double> sq_distances{1};
    EXPECT_EQ(index.search(std::vector<Vec3d>{{0, 0, 0}}, 5, found, sq_distances), 0u);
    EXPECT_TRUE(found.empty());
}

}  // namespace
}  // namespace slim::test
