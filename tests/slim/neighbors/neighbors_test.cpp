#include "slim/base/parallel.h"
#include "slim/fit/ball_points.h"
#include "slim/neighbors/knn.h"
#include "slim/neighbors/point_pyramid.h"
#include "slim/neighbors/point_tree.h"

#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

namespace slim::test {
namespace {

PointBlock random_cube(std::size_t n, std::uint64_t seed) {
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (std::size_t i = 0; i < n; ++i) {
        positions.push_back(random_in_cube(seed, i));
        normals.push_back(to_float(random_direction(seed + 1, i)));
    }
    return block_of(std::move(positions), std::move(normals));
}

/// Clouds that a tree may stumble over: sizes about a bucket and about a node, equal points, a line.
std::vector<PointBlock> hard_blocks() {
    std::vector<PointBlock> blocks;
    for (const std::size_t n : {1u, 2u, 15u, 16u, 17u, 64u, 65u, 257u, 3000u})
        blocks.push_back(random_cube(n, n));
    PointBlock equal = random_cube(200, 5);
    for (Vec3d& p : equal.position) p = {1, 2, 3};
    blocks.push_back(equal);
    PointBlock line = random_cube(500, 6);
    for (Vec3d& p : line.position) p = {p.x, 0, 0};
    blocks.push_back(line);
    return blocks;
}

std::vector<std::uint32_t> brute_ball(const PointBlock& block, const Vec3d& c, double radius) {
    std::vector<std::uint32_t> found;
    for (std::uint32_t i = 0; i < block.size(); ++i)
        if (sq_length(block.position[i] - c) < radius * radius) found.push_back(i);
    return found;
}

TEST(PointTree, BucketsInABallHoldEveryPointOfIt) {
    for (const PointBlock& block : hard_blocks()) {
        SCOPED_TRACE(block.size());
        const PointTree tree = tree_of(block);
        for (std::uint64_t q = 0; q < 40; ++q) {
            const Vec3d c = q % 2 ? random_in_cube(99, q) : block.position[q % block.size()];
            const double radius = 0.02 * static_cast<double>(q * q);
            std::set<std::uint32_t> offered;
            tree.for_buckets_in_ball(c, radius, [&](std::size_t begin, std::size_t end) {
                ASSERT_LE(end - begin, PointTree::kBucket);
                for (std::size_t i = begin; i < end; ++i)
                    EXPECT_TRUE(offered.insert(tree.source(i)).second) << "a bucket came twice";
            });
            for (const std::uint32_t i : brute_ball(block, c, radius)) EXPECT_TRUE(offered.contains(i));
        }
    }
}

TEST(PointTree, GathersTheBallsPointsScaledWithTheirNormals) {
    for (const PointBlock& block : hard_blocks()) {
        SCOPED_TRACE(block.size());
        const PointTree tree = tree_of(block);
        BallPoints<double> ball;
        for (std::uint64_t q = 0; q < 20; ++q) {
            const Vec3d c = random_in_cube(98, q);
            const double radius = 0.1 * static_cast<double>(q + 1);
            gather_ball(tree, c, radius, ball);
            std::vector<std::uint32_t> found;
            for (std::size_t k = 0; k < ball.n; ++k) {
                const std::uint32_t i = tree.source(ball.index[k]);
                found.push_back(i);
                const Vec3d x = (block.position[i] - c) / radius;
                ASSERT_NEAR(length(Vec3d{ball.x[k], ball.y[k], ball.z[k]} - x), 0, 1e-14);
                ASSERT_NEAR(ball.sq[k], sq_length(x), 1e-14);
                ASSERT_EQ((Vec3f{ball.nx[k], ball.ny[k], ball.nz[k]}), block.normal[i]);
            }
            for (std::size_t k = ball.n; k < ball.padded(); ++k) ASSERT_EQ(ball.sq[k], 2);
            std::sort(found.begin(), found.end());
            EXPECT_EQ(found, brute_ball(block, c, radius));
        }
    }
}

TEST(PointTree, CountsLikeBruteForceUpToEnough) {
    for (const PointBlock& block : hard_blocks()) {
        SCOPED_TRACE(block.size());
        const PointTree tree = tree_of(block);
        for (std::uint64_t q = 0; q < 40; ++q) {
            const Vec3d c = random_in_cube(97, q);
            const double radius = 0.05 * static_cast<double>(q + 1);
            const std::size_t all = brute_ball(block, c, radius).size();
            for (const std::size_t enough : {1u, 10u, 100000u})
                EXPECT_EQ(count_in_ball(tree, c, radius, enough), std::min<std::size_t>(all, enough));
        }
    }
}

TEST(PointTree, OfNoPointsFindsNothing) {
    const PointBlock empty;
    const PointTree tree(empty, {});
    BallPoints<float> ball;
    gather_ball(tree, {0, 0, 0}, 1, ball);
    EXPECT_EQ(ball.n, 0u);
    EXPECT_EQ(count_in_ball(tree, {0, 0, 0}, 1, 5), 0u);
}

TEST(PointPyramid, ThinningsAreNestedAndKeepTheirShare) {
    const PointBlock block = random_cube(20000, 7);
    const PointPyramid pyramid(block, box_of(block), 3);
    ASSERT_GE(pyramid.n_levels(), 3u);
    EXPECT_EQ(pyramid.all().size(), block.size());
    double expected = 20000;
    for (std::size_t l = 0; l < pyramid.n_levels(); ++l) {
        const PointTree& tree = pyramid.level(l);
        EXPECT_NEAR(static_cast<double>(tree.size()), expected, 4 * std::sqrt(expected));
        std::set<std::uint32_t> here, prefix;
        for (std::size_t i = 0; i < tree.size(); ++i) here.insert(tree.source(i));
        for (std::size_t i = 0; i < pyramid.level_size(l); ++i) prefix.insert(pyramid.by_priority()[i]);
        EXPECT_EQ(here, prefix);
        expected *= 0.381966;
    }
}

TEST(PointPyramid, IsTheSameForAnyOrderOfThePoints) {
    const PointBlock block = random_cube(5000, 8), shuffled = permuted(block, 4);
    ASSERT_NE(block.id, shuffled.id);
    const PointPyramid a(block, box_of(block), 1), b(shuffled, box_of(block), 1);
    ASSERT_EQ(a.n_levels(), b.n_levels());
    for (std::size_t l = 0; l < a.n_levels(); ++l) {
        ASSERT_EQ(a.level_size(l), b.level_size(l));
        for (std::size_t i = 0; i < a.level_size(l); ++i)
            ASSERT_EQ(block.id[a.level(l).source(i)], shuffled.id[b.level(l).source(i)]);
    }
    for (std::size_t i = 0; i < block.size(); ++i)
        ASSERT_EQ(block.id[a.by_priority()[i]], shuffled.id[b.by_priority()[i]]);
    const PointPyramid c(block, box_of(block), 2);
    EXPECT_NE(a.by_priority(), c.by_priority());
}

std::vector<double> brute_distances(const PointBlock& block, const Vec3d& q, std::size_t k) {
    std::vector<double> all;
    for (const Vec3d& p : block.position) all.push_back(sq_length(p - q));
    std::sort(all.begin(), all.end());
    all.resize(std::min(k, all.size()));
    return all;
}

TEST(KnnIndex, FindsTheNearestAtTheirDistances) {
    for (const PointBlock& block : hard_blocks()) {
        SCOPED_TRACE(block.size());
        const KnnIndex index(block.position);
        ASSERT_EQ(index.size(), block.size());
        std::vector<Vec3d> queries;
        for (std::uint64_t q = 0; q < 100; ++q)
            queries.push_back(q % 2 ? random_in_cube(96, q) * 2.0 : block.position[q % block.size()]);
        std::vector<std::uint32_t> found;
        std::vector<double> sq_distances;
        const std::size_t k = index.search(queries, 20, found, sq_distances);
        ASSERT_EQ(k, std::min<std::size_t>(20, block.size()));
        for (std::size_t q = 0; q < queries.size(); ++q) {
            const std::vector<double> expected = brute_distances(block, queries[q], k);
            for (std::size_t j = 0; j < k; ++j) {
                ASSERT_NEAR(sq_distances[q * k + j], expected[j], 1e-14);
                ASSERT_NEAR(sq_length(block.position[found[q * k + j]] - queries[q]), expected[j], 1e-14);
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
