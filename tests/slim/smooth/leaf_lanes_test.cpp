#include "slim/smooth/leaf_lanes.h"

#include "slim/base/hash.h"
#include "slim/blend/blend.h"
#include "slim/model/weight_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace slim {
namespace {

double random(std::uint64_t key, std::uint64_t what) {
    return 2 * unit_interval(keyed_hash(7, key, what)) - 1;
}

/// Leaves about a sheet near z = 0, of many sizes, some with one rim or two.
std::vector<Surfel> sheet(std::size_t n, bool rims) {
    std::vector<Surfel> leaves;
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3d tilt{0.1 * random(i, 1), 0.1 * random(i, 2), 1};
        Surfel s{{random(i, 3), random(i, 4), 0.02 * random(i, 5)},
                 0.3 + 0.1 * random(i, 6),
                 frame_from_normal(normalized(tilt)),
                 {},
                 2};
        for (std::size_t k = 0; k < 6; ++k) s.polynomial.a[k] = 0.05 * random(i, 10 + k);
        if (rims && i % 3 == 0) s.rims = {pack_rim(static_cast<int>(i % 32), 0.2), 0};
        if (rims && i % 6 == 0) s.rims.second = pack_rim(static_cast<int>((i + 9) % 32), 0.3);
        leaves.push_back(s);
    }
    return leaves;
}

Vec3d point(std::uint64_t i) {
    return {0.4 + 0.1 * random(i, 1), 0.1 * random(i, 2), 0.08 * random(i, 3)};
}
Vec3d direction(std::uint64_t i) {
    return normalized(Vec3d{random(i, 4), random(i, 5), 1.5 * random(i, 6)});
}
constexpr Bbox kBox{{0.3, -0.1, -0.08}, {0.5, 0.1, 0.08}};

TEST(LeafLanes, ProjectAsOneByOne) {
    for (const bool rims : {false, true}) {
        SCOPED_TRACE(rims);
        const BallIndex index(sheet(150, rims));
        LeafLanes lanes;
        lanes.gather(index, kBox);
        ASSERT_TRUE(lanes.are_plain());
        ASSERT_GT(lanes.numbers().size(), 8u);
        std::vector<const Surfel*> found;
        std::size_t n_hits = 0, n_misses = 0, n_beyond = 0;
        for (std::uint64_t i = 0; i < 2000; ++i) {
            const Vec3d p = point(i), n = direction(i);
            index.supporters(p, found);
            const auto one = project_along(p, n, found);
            const auto put = lanes.project_along(p, n);
            if (rims && one && !put) {  // beyond the rims of all: left to the other
                ++n_beyond;
                continue;
            }
            ASSERT_EQ(put.has_value(), one.has_value()) << i;
            ++(put ? n_hits : n_misses);
            if (!put) continue;
            ASSERT_LT(length(put->point - one->point), 1e-13) << i;
            ASSERT_LT(length(put->normal - one->normal), 1e-12) << i;
        }
        EXPECT_GT(n_hits, 500u);
        EXPECT_GT(n_misses, 500u);  // from behind
        EXPECT_LT(n_beyond, 50u);
    }
}

TEST(LeafLanes, SupportersAndTheirNormalAsTheIndexHasThem) {
    const BallIndex index(sheet(150, false));
    LeafLanes lanes;
    lanes.gather(index, kBox);
    std::vector<const Surfel*> found;
    for (std::uint64_t i = 0; i < 500; ++i) {
        const Vec3d p = point(i);
        index.supporters(p, found);
        lanes.project_along(p, {0, 0, 1});
        std::vector<std::size_t> held;
        lanes.for_supporters([&](std::uint32_t number, double weight) {
            const Surfel& s = index.leaf(number);
            EXPECT_NEAR(
                weight,
                weight_kernel(sq_length(p - s.center) / (s.support_radius * s.support_radius)),
                1e-14);
            held.push_back(number);
        });
        ASSERT_EQ(held.size(), found.size());
        for (std::size_t k = 0; k < held.size(); ++k) EXPECT_EQ(held[k], index.number_of(found[k]));
        EXPECT_LT(length(*lanes.normal_at(p) - *normal_at(p, found)), 1e-13);
    }
}

TEST(LeafLanes, CubicsAndEdgesAreLeftToOthers) {
    Surfel cubic = sheet(1, false)[0], sharp = cubic;
    cubic.center = sharp.center = {0.4, 0, 0};
    cubic.degree = 3;
    sharp.sharp = std::make_shared<const SharpSheets>();
    LeafLanes lanes;
    for (const Surfel& other : {cubic, sharp}) {
        std::vector<Surfel> leaves = sheet(20, false);
        leaves[3] = other;
        lanes.gather(BallIndex(std::move(leaves)), kBox);
        EXPECT_FALSE(lanes.are_plain());
    }
    const BallIndex plain(sheet(20, false));
    lanes.gather(plain, kBox);
    EXPECT_TRUE(lanes.are_plain());
    lanes.gather(plain, {{50, 50, 50}, {51, 51, 51}});
    EXPECT_TRUE(lanes.numbers().empty());
    EXPECT_FALSE(lanes.project_along({50, 50, 50}, {0, 0, 1}));
    EXPECT_FALSE(lanes.normal_at({50, 50, 50}));
}

// Roots of lines that touch the surface, and of surfels that are planes along them.
TEST(LeafLanes, PlanesAndTangents) {
    Surfel plane{{0, 0, 0}, 1, Frame<double>{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {}, 2};
    Surfel dome = plane;
    dome.polynomial.a = {0.1, 0, 0, -0.5, 0, -0.5};
    for (const Surfel& s : {plane, dome}) {
        const BallIndex index(std::vector<Surfel>{s});
        LeafLanes lanes;
        lanes.gather(index, {{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}});
        std::vector<const Surfel*> found{&index.leaf(0)};
        for (const Vec3d& p :
             {Vec3d{0, 0, 0}, Vec3d{0, 0, 0.1}, Vec3d{0.2, 0.1, 0.05}, Vec3d{0.2, 0, 0.08}})
            for (const Vec3d& n :
                 {Vec3d{0, 0, 1}, Vec3d{0, 0, -1}, Vec3d{1, 0, 0}, normalized(Vec3d{1, 0, 0.1})}) {
                const auto one = project_along(p, n, found);
                const auto put = lanes.project_along(p, n);
                ASSERT_EQ(put.has_value(), one.has_value()) << p.z << " " << n.x;
                if (put) {
                    EXPECT_LT(length(put->point - one->point), 1e-13);
                }
            }
    }
}

}  // namespace
}  // namespace slim
