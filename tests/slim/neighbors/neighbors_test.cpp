#include "slim/base/parallel.h"
#include "slim/fit/ball_points.h"
#include "slim/neighbors/key_sort.h"
#include "slim/neighbors/knn.h"
#include "slim/neighbors/nearest.h"
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

/// How far a bucket's floats may be off in a cloud of width 2: half a unit of 2^-24 on each axis, and some.
constexpr double kOfBuckets = 3e-7;

/// Clouds that a tree may stumble over: sizes about a bucket and about a node, equal points, a
/// line.
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
            tree.for_buckets_in_ball(c, radius, [&](std::size_t first, const PointBucket& bucket) {
                for (std::size_t k = 0; k < PointBucket::kSize; ++k) {
                    const std::size_t i = first + k;
                    ASSERT_EQ(i < tree.size(), std::isfinite(bucket.x[k]));
                    if (i >= tree.size()) continue;
                    const Vec3d at = bucket.origin + Vec3d{bucket.x[k], bucket.y[k], bucket.z[k]};
                    EXPECT_NEAR(length(at - tree.position(i)), 0, kOfBuckets);
                    EXPECT_TRUE(offered.insert(tree.source(i)).second) << "a bucket came twice";
                }
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
                const Vec3f n{ball.nx[k], ball.ny[k], ball.nz[k]};
                ASSERT_LT(length(to_double(n - block.normal[i])), 1e-4);
            }
            for (std::size_t k = ball.n; k < ball.padded(); ++k) ASSERT_EQ(ball.sq[k], 2);
            std::sort(found.begin(), found.end());
            EXPECT_EQ(found, brute_ball(block, c, radius));
        }
    }
}

TEST(PointTree, ACloudOfFloatsIsKeptAsItIs) {
    PointBlock block = random_cube(3000, 4);
    for (Vec3d& p : block.position) p = to_double(to_float(p * 0.1 + Vec3d{0.3, 0.3, 0.3}));
    const PointTree tree = tree_of(block);
    BallPoints<double> ball;
    gather_ball(tree, block.position[0], 10, ball);
    ASSERT_EQ(ball.n, block.size());
    for (std::size_t k = 0; k < ball.n; ++k) {
        const Vec3d x = (tree.position(ball.index[k]) - block.position[0]) / 10;
        ASSERT_NEAR(length(Vec3d{ball.x[k], ball.y[k], ball.z[k]} - x), 0, 1e-15);
    }
}

TEST(ShrinkBall, LeavesWhatAGatheredBallHolds) {
    for (const PointBlock& block : hard_blocks()) {
        SCOPED_TRACE(block.size());
        const PointTree tree = tree_of(block);
        BallPoints<float> shrunk, gathered;
        for (std::uint64_t q = 0; q < 20; ++q) {
            const Vec3d c = random_in_cube(98, q);
            gather_ball(tree, c, 1, shrunk);
            shrink_ball(shrunk, 0.618);
            gather_ball(tree, c, 0.618, gathered);
            ASSERT_EQ(shrunk.n, gathered.n);
            EXPECT_EQ(shrunk.radius, 0.618);
            for (std::size_t k = 0; k < shrunk.padded(); ++k) {
                ASSERT_NEAR(shrunk.x[k], gathered.x[k], 2e-6);
                ASSERT_NEAR(shrunk.sq[k], gathered.sq[k], 4e-6);
                ASSERT_EQ(shrunk.nz[k], gathered.nz[k]);
            }
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

TEST(PointPyramid, OfAShareGoesOnWithTheThinningsOfTheWhole) {
    const PointBlock block = random_cube(20000, 7);
    const PointPyramid whole(block, box_of(block), 3);
    PointBlock sample;
    for (std::size_t i = 0; i < block.size(); ++i) {
        if (!in_share(3, block.id[i], 0.25)) continue;
        sample.position.push_back(block.position[i]);
        sample.id.push_back(block.id[i]);
    }
    EXPECT_NEAR(static_cast<double>(sample.size()), 5000, 250);
    const PointPyramid part(sample, box_of(block), 3, 0.25);  // between the shares 0.38 and 0.15
    ASSERT_EQ(part.n_levels() + 1, whole.n_levels());
    for (std::size_t l = 1; l < part.n_levels(); ++l) {
        ASSERT_EQ(part.level_size(l), whole.level_size(l + 1));
        EXPECT_EQ(part.share(l), whole.share(l + 1));
        for (std::size_t i = 0; i < part.level_size(l); ++i)
            ASSERT_EQ(sample.id[part.level(l).source(i)],
                      block.id[whole.level(l + 1).source(i)]);
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

TEST(KeySort, SortsByKeyAndKeepsTheOrderOfEqualOnes) {
    for (const std::size_t n : {0u, 1u, 100u, 5000u, 200000u})
        for (const std::uint64_t mask : {~0ull, 0xffull, 0xff00ff0000ull, 0ull}) {
            SCOPED_TRACE(testing::Message() << n << " items, mask " << mask);
            KeyedIndices items(n);
            for (std::uint32_t i = 0; i < n; ++i) items[i] = {keyed_hash(3, i) & mask, i};
            KeyedIndices expected = items;
            std::stable_sort(expected.begin(), expected.end(),
                             [](const auto& a, const auto& b) { return a.key < b.key; });
            const ThreadLimit limit(3);
            sort_by_key(items);
            EXPECT_TRUE(items == expected);
            sort_by_key(items);
            EXPECT_TRUE(items == expected);
        }
}

TEST(KeySort, SortsACrowdInOneCornerOfTheRange) {
    KeyedIndices items(400000);
    for (std::uint32_t i = 0; i < items.size(); ++i) {
        const std::uint64_t key = keyed_hash(5, i) >> 1;
        items[i] = {i % 8 == 0 ? key : key >> 20, i};
    }
    KeyedIndices expected = items;
    std::stable_sort(expected.begin(), expected.end(),
                     [](const auto& a, const auto& b) { return a.key < b.key; });
    const ThreadLimit limit(3);
    sort_by_key(items);
    EXPECT_TRUE(items == expected);
}

TEST(SortAlongCurve, PutsRepeatsSideBySideWhateverTheOrderTheyCameIn) {
    PointBlock block = random_cube(3000, 12);
    for (std::size_t i = 0; i < 1000; ++i) block.position[i] = block.position[i % 70];
    for (std::size_t i = 0; i < block.size(); ++i)
        block.scan.push_back(static_cast<std::uint16_t>(block.id[i] % 7));
    PointBlock other = permuted(block, 5);
    for (const std::uint64_t id : other.id) other.scan.push_back(static_cast<std::uint16_t>(id % 7));
    const Bbox box = box_of(block);
    sort_along_curve(block, box);
    sort_along_curve(other, box);
    EXPECT_EQ(block.position, other.position);
    EXPECT_EQ(block.normal, other.normal);
    EXPECT_EQ(block.id, other.id);
    EXPECT_EQ(block.scan, other.scan);
    const std::vector<std::uint32_t> order = morton_order(block, box);
    EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
    const NearestSearch search(block.position);
    std::size_t repeats = 0;
    for (std::size_t i = 0; i < block.size(); ++i) repeats += search.is_repeat(i);
    EXPECT_EQ(repeats, 930u);
}

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
void expect_nearest(const PointBlock& block, const std::vector<std::uint32_t>& wanted, std::size_t k) {
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
    for (std::size_t i = 0; i < block.size(); i += step) wanted.push_back(static_cast<std::uint32_t>(i));
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
            .for_each(every(block, 1), 12, [&](std::size_t w, std::span<const std::uint32_t> found) {
                std::copy(found.begin(), found.end(), all.begin() + static_cast<std::ptrdiff_t>(w * 12));
            });
        answers.push_back(all);
    }
    EXPECT_EQ(answers[0], answers[1]);
    EXPECT_EQ(answers[0], answers[2]);
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
