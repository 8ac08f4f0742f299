#include "slim/cover/own_leaves.h"

#include "slim/base/parallel.h"
#include "slim/blend/blend.h"
#include "slim/cover/sound_normal.h"
#include "slim/model/surfel_encoder.h"
#include "tests/slim/cover/cover_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace slim::test {
namespace {

/// Largest distance of points to the blend of leaves as the file holds them, along their normals;
/// infinite where none supports one.
double farthest_off(const PointBlock& points, const Cover& c) {
    double most = 0;
    auto leaves = leaves_of(c);
    for (FittedSurfel& s : leaves) s.surfel = level_linear(s.surfel);
    for (std::size_t i = 0; i < points.size(); ++i) {
        std::vector<const Surfel*> near;
        for (const FittedSurfel& s : leaves)
            if (length(points.position[i] - s.surfel.center) < s.surfel.support_radius)
                near.push_back(&s.surfel);
        const auto at =
            project_along(points.position[i], normalized(to_double(points.normal[i])), near);
        most = std::max(most, at ? std::abs(at->t) : INFINITY);
    }
    return most;
}

/// A bowl with a ridge across it, two points wide: too little of a large leaf for its eps to show
/// it.
PointBlock ridge() {
    const auto height = [](double u, double v) {
        return 0.1 * (u * u + v * v) + 0.025 * std::exp(-u * u / 4e-4);
    };
    PointBlock block = along_curve(graph_points(20000, 1, 1, height));
    for (std::size_t i = 0; i < block.size(); ++i) {
        const Vec3d p = block.position[i];
        const double e = 0.025 * std::exp(-p.x * p.x / 4e-4);
        block.normal[i] =
            to_float(normalized(Vec3d{-0.2 * p.x + e * 2 * p.x / 4e-4, -0.2 * p.y, 1}));
    }
    return block;
}

CoverRules clean_rules(const PointBlock& block, double mdl_threshold) {
    CoverRules rules = rules_for(block, mdl_threshold);
    rules.refits = true;
    return rules;
}

TEST(OwnLeaves, NoPointIsFartherOffThanTAndNoiseAllow) {
    const PointBlock block = ridge();
    CoverRules rules = clean_rules(block, 0.005);
    const Cover c = cover(block, rules);
    EXPECT_LE(farthest_off(block, c), rules.farthest());
    EXPECT_GT(c.counts.own, 0u);
    EXPECT_EQ(c.counts.leaves, leaves_of(c).size());
    rules.refits = false;
    EXPECT_GT(farthest_off(block, cover(block, rules)), 1.5 * rules.farthest())
        << "the ridge is no test of it";
}

/// A noisy bowl with every fiftieth normal turned across the surface, as grazing rays measure them.
PointBlock bowl_with_stray_normals() {
    PointBlock block = along_curve(
        graph_points(20000, 1, 5, [](double u, double v) { return 0.1 * (u * u + v * v); }));
    for (std::size_t i = 0; i < block.size(); ++i) {
        Vec3d& p = block.position[i];
        const Vec3d n = normalized(Vec3d{-0.2 * p.x, -0.2 * p.y, 1});
        p += n * (1e-3 * gaussian(9, i));
        const double angle = static_cast<double>(i);
        block.normal[i] = to_float(
            i % 50 == 0 ? normalized(frame_from_normal(n).u_axis * std::cos(angle) +
                                     frame_from_normal(n).v_axis * std::sin(angle) + n * 0.01)
                        : n);
    }
    return block;
}

// Such a point lies on the surface, far from it along its own normal alone: a leaf of its own would
// be a false spot in a map of curvature.
TEST(OwnLeaves, AStrayNormalMakesNoPointFar) {
    const PointBlock block = bowl_with_stray_normals();
    CoverRules rules = clean_rules(block, 0.005);
    EXPECT_GT(cover(block, rules).counts.own, 0u) << "normals say so where strays are no noise";
    rules.ladder.contrary_share = 0.02;
    const Cover c = cover(block, rules);
    EXPECT_EQ(c.counts.own, 0u);
    for (const FittedSurfel& s : leaves_of(c)) EXPECT_GT(s.n_points, 30u);
}

TEST(OwnLeaves, ASoundNormalIsTheOthersWhereTheyAgreeAndItsOwnIsAcross) {
    PointBlock block = along_curve(graph_points(400, 1, 3, [](double, double) { return 0.0; }));
    for (Vec3f& n : block.normal) n = {0, 0, 1};
    const std::uint32_t place = 100;
    const auto normal = [&](const Vec3f& own) {
        const PointTree all = tree_of(block);
        block.normal[all.source(place)] = own;
        const PointTree tree = tree_of(block);
        return sound_normal(tree, place);
    };
    EXPECT_EQ(normal({1, 0, 0}), (Vec3d{0, 0, 1}));
    EXPECT_EQ(normal({0, 0, -1}), (Vec3d{0, 0, -1}));  // the other side's
    EXPECT_NEAR(normal({0.8f, 0, 0.6f}).x, 0.8, 1e-6);  // an edge's
    EXPECT_EQ(normal({0, 0, 0}), (Vec3d{}));
    for (std::size_t i = 0; i < block.size(); i += 2) block.normal[i] = {0, 1, 0};
    EXPECT_EQ(normal({1, 0, 0}), (Vec3d{1, 0, 0}));  // nobody agrees
}

// Upright walls are where frames of normals near each other differ most: the rims of linear leaves
// turn with the file's.
TEST(OwnLeaves, OfAWallOfLinearLeavesToo) {
    PointBlock wall = ridge();
    for (Vec3d& p : wall.position) p = {p.z, p.x, p.y};
    for (Vec3f& n : wall.normal) n = {n.z, n.x, n.y};
    const PointBlock block = along_curve(wall);
    CoverRules rules = clean_rules(block, 0.005);
    rules.degree = 1;
    const Cover c = cover(block, rules);
    EXPECT_LE(farthest_off(block, c), rules.farthest());
    EXPECT_GT(c.counts.own, 0u);
}

TEST(OwnLeaves, ALargerTAllowsMore) {
    const PointBlock block = ridge();
    const CoverRules fine = clean_rules(block, 0.005), coarse = clean_rules(block, 0.05);
    EXPECT_DOUBLE_EQ(coarse.farthest(), 10 * fine.farthest());
    const Cover c = cover(block, coarse);
    EXPECT_EQ(c.counts.own, 0u);
    EXPECT_LT(c.counts.leaves, cover(block, fine).counts.leaves);
}

TEST(OwnLeaves, AreTheSameForAnyNumberOfThreads) {
    const PointBlock block = ridge();
    const CoverRules rules = clean_rules(block, 0.005);
    const auto with = [&](int n) {
        const ThreadLimit limit(n);
        return cover(block, rules);
    };
    expect_same(with(1), with(2));
}

// Nobody's surface: what is dropped as a stray stays so.
TEST(OwnLeaves, StraysGetNone) {
    PointBlock block = ridge();
    for (int k = 0; k < 3; ++k) {
        block.position.push_back({0.2 * k, 0.1, 3.0 + k});
        block.normal.push_back({0, 0, 1});
        block.id.push_back(block.size());
    }
    block = along_curve(block);
    const Cover c = cover(block, clean_rules(block, 0.005));
    EXPECT_EQ(c.counts.isolated, 3u);
    for (const FittedSurfel& f : leaves_of(c)) EXPECT_LT(f.surfel.center.z, 1);
}

}  // namespace
}  // namespace slim::test
