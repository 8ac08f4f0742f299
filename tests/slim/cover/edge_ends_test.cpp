#include "slim/cover/edge_ends.h"

#include "slim/cover/drawn_part.h"
#include "slim/cover/surfel_fit.h"
#include "tests/slim/cover/cover_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace slim::test {
namespace {

/// Points of the faces z = 0 (x <= 0) and x = 0 (z <= 0), which meet in the y axis.
PointBlock edge_points() {
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (int i = 0; i < 20; ++i)
        for (int j = -20; j <= 20; ++j) {
            const double away = -0.025 - 0.05 * i, along = 0.05 * j;
            positions.push_back({away, along, 0}), normals.push_back({0, 0, 1});
            positions.push_back({0, along, away}), normals.push_back({1, 0, 0});
        }
    return along_curve(block_of(std::move(positions), std::move(normals)));
}

/// Leaves at that edge: a smooth one of the upper face that reaches 0.19 beyond it, and others.
struct EdgeScene {
    PointBlock block = edge_points();
    PointTree tree = tree_of(block);
    std::vector<std::vector<FittedSurfel>> leaves{1};
    std::vector<BlendResidual> blend = std::vector<BlendResidual>(block.size());
    std::vector<std::uint8_t> n_drawn = std::vector<std::uint8_t>(block.size());
    NeedlessRules rules{1e-8, 1e-3, 0.1};

    EdgeScene() { add({-0.1, 0, 0}, 0.4); }

    FittedSurfel& add(const Vec3d& center, double rho) {
        FittedSurfel f;
        f.surfel = {center, rho, frame_from_normal(Vec3d{0, 0, 1}), {}, 1};
        f.flags = kLeaf, f.fit_error = 1e-4;
        return leaves.front().emplace_back(f);
    }
    /// Both faces about the origin.
    void add_edge(double rho, double fit_error = 1e-4) {
        FittedSurfel& f = add({0, 0, 0}, rho);
        auto more = std::make_shared<SharpSheets>();
        more->extra[0] = {frame_from_normal(Vec3d{1, 0, 0}), {}};
        f.surfel.sharp = more, f.fit_error = fit_error;
    }
    /// The leaves' shares of what stands beside them.
    void share(std::vector<BlendResidual>& sums, std::vector<std::uint8_t>& drawn) const {
        BallPoints<double> ball;
        for (const FittedSurfel& f : leaves.front())
            for (const Covered& p : cover_again(tree, f, rules.noise_variance, ball).covered) {
                const LeafShare s = LeafShares(f.surfel).of(p);
                sums[s.point].weight += s.weight, sums[s.point].height += s.height;
                drawn[s.point] = static_cast<std::uint8_t>(drawn[s.point] + s.is_drawn);
            }
    }
    std::size_t end() {
        share(blend, n_drawn);
        return end_at_edges(tree, rules, blend, n_drawn, leaves);
    }
    bool is_drawn(double x) const {
        return is_drawn_at(leaves.front().front().surfel, {x, 0, 0}, {0, 0, 1});
    }
};

TEST(EdgeEnds, ALeafEndsWhereASharpOneShowsTheEdge) {
    EdgeScene s;
    ASSERT_TRUE(s.is_drawn(0.1));
    s.add_edge(0.6);
    EXPECT_EQ(s.end(), 1u);
    EXPECT_FALSE(s.is_drawn(0.04));
    EXPECT_TRUE(s.is_drawn(-0.05));
    std::vector<BlendResidual> blend(s.block.size());
    std::vector<std::uint8_t> n_drawn(s.block.size());
    s.share(blend, n_drawn);
    EXPECT_EQ(n_drawn, s.n_drawn);
    for (std::size_t i = 0; i < blend.size(); ++i)
        EXPECT_NEAR(blend[i].weight, s.blend[i].weight, 1e-6) << i;
}

TEST(EdgeEnds, ARoughSharpLeafSaysNothing) {
    EdgeScene s;
    s.add_edge(0.6, 0.03);
    EXPECT_EQ(s.end(), 0u);
    EXPECT_TRUE(s.is_drawn(0.1));
}

TEST(EdgeEnds, WithoutSharpLeavesAllStay) {
    EdgeScene s;
    s.add({0, 0, 0}, 0.6);
    EXPECT_EQ(s.end(), 0u);
    EXPECT_FALSE(s.leaves.front().front().surfel.rims.any());
}

TEST(EdgeEnds, WhatALeafAloneDrawsStays) {
    EdgeScene s;
    // The edge's leaf holds places beyond the edge in its ball, but draws little of the face.
    s.add_edge(0.2);
    s.end();
    for (double x = -0.36; x < 0; x += 0.02) EXPECT_TRUE(s.is_drawn(x)) << x;
}

}  // namespace
}  // namespace slim::test
