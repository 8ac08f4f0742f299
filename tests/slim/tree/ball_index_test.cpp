#include "slim/tree/ball_index.h"

#include "slim/base/hash.h"
#include "slim/model/surfel_encoder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace slim {
namespace {

Vec3d random_point(std::uint64_t seed, std::uint64_t key) {
    return {unit_interval(keyed_hash(seed, key, 1)), unit_interval(keyed_hash(seed, key, 2)),
            unit_interval(keyed_hash(seed, key, 3))};
}

/// n leaves of many sizes below a root, in a unit cube at `corner`.
SurfelTreeData leaves(std::size_t n, std::uint64_t seed, const Vec3d& corner) {
    std::vector<Surfel> surfels(
        1, Surfel{corner + Vec3d{0.5, 0.5, 0.5}, 2, frame_from_normal(Vec3d{0, 0, 1}), {}, 2});
    SurfelTreeData data;
    data.header.degree = 2;
    data.nodes.resize(n + 1);
    for (std::size_t i = 0; i < n; ++i) {
        const double rho = 0.4 * std::pow(unit_interval(keyed_hash(seed, i)), 4) + 0.01;
        surfels.push_back(
            {corner + random_point(seed, i), rho, frame_from_normal(Vec3d{0, 0, 1}), {}, 2});
        data.nodes[i + 1].flags = kLeaf;
        data.nodes[i + 1].degree = 2;
    }
    encode_surfels(surfels, data);
    return data;
}

TEST(BallIndex, FindsTheBallsThatBruteForceFindsInOneOrder) {
    for (const std::size_t n : {std::size_t{1}, std::size_t{8}, std::size_t{9}, std::size_t{700}}) {
        for (const Vec3d& corner : {Vec3d{0, 0, 0}, Vec3d{-1e6, 3e5, 1e7}}) {
            SCOPED_TRACE(n);
            const SurfelTreeData data = leaves(n, n, corner);
            const SurfelTree tree = data.view();
            const BallIndex index(tree);
            ASSERT_EQ(index.n_leaves(), n);
            std::vector<const Surfel*> found;
            for (std::uint64_t k = 0; k < 2000; ++k) {
                const Vec3d p = corner + random_point(99, k) * 1.2 - Vec3d{0.1, 0.1, 0.1};
                std::size_t expected = 0;
                for (std::size_t i = 1; i <= n; ++i)
                    expected += length(p - tree.center(i)) < tree.support_radius(i) ? 1 : 0;
                index.supporters(p, found);
                ASSERT_EQ(found.size(), expected);
                for (const Surfel* s : found) ASSERT_LT(length(p - s->center), s->support_radius);
                ASSERT_TRUE(std::is_sorted(found.begin(), found.end()));
            }
        }
    }
}

TEST(BallIndex, NearABoxAreTheBallsThatMeetIt) {
    const SurfelTreeData data = leaves(700, 3, {});
    const BallIndex index(data.view());
    std::vector<std::uint32_t> found;
    for (std::uint64_t k = 0; k < 200; ++k) {
        const Vec3d lo = random_point(98, k), size = random_point(97, k) * 0.2;
        const Bbox box{lo, lo + size};
        std::vector<std::uint32_t> expected;
        for (std::uint32_t i = 0; i < index.n_leaves(); ++i) {
            const Surfel& s = index.leaf(i);
            double sq = 0;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double x = s.center[axis];
                const double off = std::max({box.lo[axis] - x, x - box.hi[axis], 0.0});
                sq += off * off;
            }
            if (std::sqrt(sq) < s.support_radius) expected.push_back(i);
        }
        index.near(box, found);
        ASSERT_EQ(found, expected);
    }
    index.near(Bbox{}, found);
    EXPECT_TRUE(found.empty());
}

TEST(BallIndex, WithoutLeavesNothingIsFound) {
    const SurfelTreeData data = leaves(0, 1, {});
    const BallIndex index(data.view());
    std::vector<const Surfel*> found(3);
    index.supporters({0.5, 0.5, 0.5}, found);
    EXPECT_TRUE(found.empty());
}

}  // namespace
}  // namespace slim
