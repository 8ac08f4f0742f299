#include "slim/neighbors/point_tree.h"

#include "slim/fit/ball_points.h"
#include "tests/slim/neighbors/neighbors_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

namespace slim::test {
namespace {

/// How far a bucket's floats may be off in a cloud of width 2: half a unit of 2^-24 on each axis,
/// and some.
constexpr double kOfBuckets = 3e-7;

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
            for (const std::uint32_t i : brute_ball(block, c, radius))
                EXPECT_TRUE(offered.contains(i));
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

TEST(PointTree, CountsLikeBruteForceUpToEnough) {
    for (const PointBlock& block : hard_blocks()) {
        SCOPED_TRACE(block.size());
        const PointTree tree = tree_of(block);
        for (std::uint64_t q = 0; q < 40; ++q) {
            const Vec3d c = random_in_cube(97, q);
            const double radius = 0.05 * static_cast<double>(q + 1);
            const std::size_t all = brute_ball(block, c, radius).size();
            for (const std::size_t enough : {1u, 10u, 100000u})
                EXPECT_EQ(count_in_ball(tree, c, radius, enough),
                          std::min<std::size_t>(all, enough));
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

TEST(GatherDisc, HoldsThePointsWhoseFeetAreInIt) {
    constexpr double kDisc = 0.3, kBall = 0.5, kMargin = 1e-5;
    constexpr float kLeastCos = 0.2f;
    for (const PointBlock& block : hard_blocks()) {
        SCOPED_TRACE(block.size());
        const PointTree tree = tree_of(block);
        BallPoints<float> disc;
        for (std::uint64_t q = 0; q < 20; ++q) {
            const Vec3d c = random_in_cube(98, q), normal = random_direction(97, q);
            gather_disc(tree, c, normal, kDisc, kBall, kLeastCos, disc);
            // By brute force, a little narrower and a little wider: floats decide between.
            std::size_t least = 0, most = 0;
            for (std::size_t i = 0; i < tree.size(); ++i) {
                const Vec3d d = tree.position(i) - c, n = to_double(tree.normal(i));
                const double foot = length(d - normal * dot(d, normal)), cosine = dot(n, normal);
                const bool own = sq_length(n) > 0;
                least += length(d) < kBall - kMargin && foot < kDisc - kMargin &&
                         (!own || cosine > 0.2 + 1e-3);
                most += length(d) < kBall + kMargin && foot < kDisc + kMargin &&
                        (!own || cosine > 0.2 - 1e-3);
            }
            EXPECT_GE(disc.n, least);
            EXPECT_LE(disc.n, most);
            for (std::size_t k = 0; k < disc.n; ++k) {
                const Vec3d x{disc.x[k], disc.y[k], disc.z[k]};
                const double off = dot(x, normal);
                ASSERT_NEAR(disc.sq[k], sq_length(x) - off * off, 1e-5);
                ASSERT_LT(disc.sq[k], 1);
            }
        }
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
            shrink_ball(shrunk, 0.618, shrunk);
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

}  // namespace
}  // namespace slim::test
