#include "slim/tree/stand_ins.h"

#include "slim/model/stand_in.h"
#include "slim/tree/tree_builder.h"
#include "tests/raytrace/support/analytic_models.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace slim {
namespace {

FittedSurfel fitted(const Surfel& s, int level, bool leaf) {
    FittedSurfel f;
    f.surfel = s;
    f.level = static_cast<std::uint8_t>(level);
    f.flags = leaf ? kLeaf : 0;
    f.n_points = 50;
    return f;
}

SurfelTreeData tree_of(const std::vector<FittedSurfel>& surfels) {
    ModelHeader header;
    header.diagonal = 2;
    TreeCounts counts;
    return build_tree(surfels, header, counts);
}

bool is_marked(const TreeNode& node) { return (node.flags & kStandsIn) != 0; }

std::size_t n_marked(const SurfelTreeData& data) {
    std::size_t n = 0;
    for (const TreeNode& node : data.nodes) n += is_marked(node);
    return n;
}

Surfel flat(const Vec3d& center, const Vec3d& normal, double radius) {
    return {center, radius, frame_from_normal(round_normal(normal)), {}, 2};
}

/// Coarse and fine flat surfels over [-1, 1]^2 at height 0; those of x < wall only.
void add_floor(double wall, std::vector<FittedSurfel>& out) {
    for (const auto& [n, radius, level] : {std::tuple{10, 0.25, 1}, std::tuple{80, 0.05, 2}})
        for (int i = 0; i < n; ++i)
            for (int k = 0; k < n; ++k) {
                const Vec3d c{2 * (i + 0.5) / n - 1, 2 * (k + 0.5) / n - 1, 0};
                if (c.x < wall)
                    out.push_back(fitted(flat(c, {0, 0, 1}, radius), level, level == 2));
            }
}

TEST(StandIns, AreThoseThatLeavesAgreeWithAllOver) {
    std::vector<FittedSurfel> surfels;
    for (const Surfel& s : test::sphere_leaves(1, 200, 6, 2))
        surfels.push_back(fitted(s, 1, false));
    for (const Surfel& s : test::sphere_leaves(1, 20000, 6, 2))
        surfels.push_back(fitted(s, 2, true));
    SurfelTreeData data = tree_of(surfels);
    EXPECT_EQ(mark_stand_ins(data), 200u);
    EXPECT_EQ(n_marked(data), 200u);
    for (const TreeNode& node : data.nodes) EXPECT_FALSE(is_marked(node) && node.is_leaf());
}

TEST(StandIns, NoneReachesBeyondABorder) {
    std::vector<FittedSurfel> surfels;
    add_floor(0.5, surfels);
    SurfelTreeData data = tree_of(surfels);
    EXPECT_GT(mark_stand_ins(data), 10u);
    const SurfelTree tree = data.view();
    for (std::size_t i = 1; i < tree.n_nodes(); ++i) {
        if (!is_marked(tree.node(i))) continue;
        EXPECT_LT(tree.center(i).x + 0.9 * tree.support_radius(i), 0.5 + 0.05);
        EXPECT_LT(std::abs(tree.center(i).y) + 0.9 * tree.support_radius(i), 1 + 0.05);
    }
}

TEST(StandIns, NoneReachesBeyondAnEdge) {
    std::vector<FittedSurfel> surfels;
    add_floor(0.5, surfels);
    for (int i = 0; i < 40; ++i)  // a wall down from x = 0.5
        for (int k = 0; k < 80; ++k)
            surfels.push_back(fitted(
                flat({0.5, 2 * (k + 0.5) / 80 - 1, -(i + 0.5) / 40}, {1, 0, 0}, 0.05), 2, true));
    SurfelTreeData data = tree_of(surfels);
    EXPECT_GT(mark_stand_ins(data), 10u);
    const SurfelTree tree = data.view();
    for (std::size_t i = 1; i < tree.n_nodes(); ++i)
        if (is_marked(tree.node(i)) && std::abs(tree.center(i).z) < 1e-6) {
            EXPECT_LT(tree.center(i).x + 0.9 * tree.support_radius(i), 0.5 + 0.05);
        }
}

TEST(StandIns, NeedAGoodFitManyChildrenAndSoundLeaves) {
    const auto marked = [](auto&& spoil, std::size_t n_leaves = 20000) {
        std::vector<FittedSurfel> surfels;
        for (const Surfel& s : test::sphere_leaves(1, 200, 6, 2))
            surfels.push_back(fitted(s, 1, false));
        for (const Surfel& s : test::sphere_leaves(1, n_leaves, 6, 2))
            surfels.push_back(fitted(s, 2, true));
        spoil(surfels);
        SurfelTreeData data = tree_of(surfels);
        return mark_stand_ins(data);
    };
    EXPECT_EQ(marked([](auto& all) {
        for (FittedSurfel& f : all) f.fit_error = 0.1 * f.surfel.support_radius;
    }), 0u);
    EXPECT_EQ(marked([](auto& all) {
        for (FittedSurfel& f : all)
            if (f.flags & kLeaf) f.flags |= kLoose;
    }), 0u);
    EXPECT_EQ(marked([](auto& all) {
        for (FittedSurfel& f : all)
            if (f.flags & kLeaf) f.surfel.rims = {pack_rim(3, 0.2), 0};
    }), 0u);
    EXPECT_EQ(marked([](auto&) {}), 200u);
    EXPECT_EQ(marked([](auto&) {}, 800), 0u);  // four children each
}

TEST(StandIns, AreDrawnInTheWholeOfTheirBall) {
    Surfel s = flat({0, 0, 0}, {0, 0, 1}, 2);
    s.polynomial.a = {0.1, 0.02, -0.03, 0.2, 0.05, -0.1, 0.01, 0.02, -0.03, 0.04};
    const Surfel drawn = in_larger_ball(s, kStandInScale);
    EXPECT_DOUBLE_EQ(drawn.support_radius * kHitTrim, s.support_radius);
    for (const Vec3d& p : {Vec3d{0.3, -0.4, 0.2}, Vec3d{1.1, 0.9, -0.3}}) {
        const Vec3d x = p / s.support_radius, y = p / drawn.support_radius;
        EXPECT_NEAR(s.value(x) * s.support_radius, drawn.value(y) * drawn.support_radius, 1e-12);
    }
}

}  // namespace
}  // namespace slim
