#include "slim/tree/drawn_bounds.h"

#include "slim/tree/tree_builder.h"
#include "tests/raytrace/support/analytic_models.h"

#include <gtest/gtest.h>

#include <vector>

namespace slim {
namespace {

/// n x n flat leaves over [0, 1]^2 at height z; `flags` of all.
std::vector<FittedSurfel> sheet(int n, double z, std::uint8_t flags = kLeaf) {
    std::vector<FittedSurfel> out;
    for (int i = 0; i < n; ++i)
        for (int k = 0; k < n; ++k) {
            FittedSurfel f;
            f.surfel = {{(i + 0.5) / n, (k + 0.5) / n, z},
                        1.0 / n,
                        frame_from_normal(round_normal({0, 0, 1})),
                        {},
                        2};
            f.level = 2;
            f.flags = flags;
            f.n_points = 50;
            out.push_back(f);
        }
    return out;
}

SurfelTreeData model(const std::vector<FittedSurfel>& leaves, const Bbox& points) {
    ModelHeader header;
    header.bounds = points;
    header.diagonal = points.diagonal();
    TreeCounts counts;
    return build_tree(leaves, header, counts);
}

TEST(DrawnBounds, ArePointsWhereAllAreCovered) {
    const Bbox points{{0, 0, 0}, {1, 1, 1e-3}};
    const Bbox box = drawn_bounds(model(sheet(20, 0), points).view(), false);
    EXPECT_EQ(box.lo, points.lo);
    EXPECT_EQ(box.hi.x, 1);
    EXPECT_EQ(box.hi.y, 1);
    EXPECT_NEAR(box.hi.z, 0, 1e-3);
}

TEST(DrawnBounds, AreNotStretchedByStraysThatNoLeafCovers) {
    const Bbox points{{-50, 0, -30}, {1, 80, 40}};
    const SurfelTreeData data = model(sheet(40, 0), points);
    const Bbox box = drawn_bounds(data.view(), false);
    constexpr double kRim = 0.5 / 40 + 1e-6;  // of a leaf, which reaches beyond its points
    EXPECT_NEAR(box.lo.x, 0, kRim);
    EXPECT_EQ(box.hi.x, 1);
    EXPECT_EQ(box.lo.y, 0);
    EXPECT_NEAR(box.hi.y, 1, kRim);
    EXPECT_NEAR(box.lo.z, 0, 1e-6);
    EXPECT_NEAR(box.hi.z, 0, 1e-6);
}

std::size_t n_visited(const SurfelTreeData& data) {
    std::vector<std::uint32_t> visited;
    drawn_bounds(data.view(), false, &visited);
    return visited.size();
}

/// Six walls of n x n flat leaves about the unit cube.
std::vector<FittedSurfel> room(int n) {
    std::vector<FittedSurfel> out;
    for (const std::size_t axis : {0u, 1u, 2u})
        for (const double side : {0.0, 1.0})
            for (FittedSurfel f : sheet(n, side)) {
                const Vec3d c = f.surfel.center;
                Vec3d normal;
                normal[axis] = 1;
                f.surfel.center = {c[(5 - axis) % 3], c[(6 - axis) % 3], c[(7 - axis) % 3]};
                f.surfel.frame = frame_from_normal(round_normal(normal));
                out.push_back(f);
            }
    return out;
}

/// n leaves over the unit sphere in levels of half the radius each.
SurfelTreeData sphere_tree(std::size_t n) {
    std::vector<FittedSurfel> out;
    int level = 1;
    for (std::size_t k = 40; k < 4 * n; k *= 4, ++level) {
        const bool leaf = 4 * k >= 4 * n;
        const std::size_t here = leaf ? n : k;
        for (const Surfel& s : test::sphere_leaves(1, here, 6, 2)) {
            FittedSurfel f;
            f.surfel = s;
            f.level = static_cast<std::uint8_t>(level);
            f.flags = leaf ? kLeaf : 0;
            f.n_points = 50;
            out.push_back(f);
        }
    }
    return model(out, {{-50, -60, -30}, {70, 80, 40}});
}

TEST(DrawnBounds, AreFoundOnARoundModelByAFewNodes) {
    const SurfelTreeData data = sphere_tree(20000);
    EXPECT_LT(n_visited(data), data.nodes.size() / 3);
}

TEST(DrawnBounds, AreKnownOfFlatModelsAndRoomsWithStraysWithoutANode) {
    const Bbox points{{-50, -60, -30}, {70, 80, 40}};
    for (const auto& leaves : {sheet(60, 0), room(30)}) {
        SurfelTreeData data = model(leaves, points);
        const Bbox searched = drawn_bounds(data.view(), false);
        EXPECT_GT(n_visited(data), leaves.size());  // why it is kept: the search meets every one
        set_drawn_bounds(data);
        EXPECT_EQ(n_visited(data), 0u);
        EXPECT_EQ(drawn_bounds(data.view(), false).lo, searched.lo);
        EXPECT_EQ(drawn_bounds(data.view(), false).hi, searched.hi);
    }
}

TEST(DrawnBounds, KeptAreThoseOfTheSearchWithAndWithoutLooseLeaves) {
    std::vector<FittedSurfel> leaves = sheet(20, 0);
    for (const FittedSurfel& f : sheet(2, 8, kLeaf | kLoose)) leaves.push_back(f);
    SurfelTreeData data = model(leaves, {{0.1, -1, -1}, {1, 1, 9}});
    const Bbox without = drawn_bounds(data.view(), false), with = drawn_bounds(data.view(), true);
    set_drawn_bounds(data);
    EXPECT_EQ(data.header.drawn.lo, without.lo);
    EXPECT_EQ(data.header.drawn.hi, without.hi);
    EXPECT_EQ(data.header.drawn_loose.lo, with.lo);
    EXPECT_EQ(data.header.drawn_loose.hi, with.hi);
    EXPECT_LT(without.hi.z, with.hi.z);
    EXPECT_EQ(drawn_bounds(data.view(), true).hi, with.hi);
}

TEST(DrawnBounds, HoldLooseLeavesIfTheyAreDrawn) {
    const Bbox points{{0, 0, 0}, {1, 1, 9}};
    std::vector<FittedSurfel> leaves = sheet(20, 0);
    for (const FittedSurfel& f : sheet(2, 8, kLeaf | kLoose)) leaves.push_back(f);
    const SurfelTreeData data = model(leaves, points);
    EXPECT_NEAR(drawn_bounds(data.view(), false).hi.z, 0, 1e-6);
    EXPECT_NEAR(drawn_bounds(data.view(), true).hi.z, 8, 1e-6);
}

TEST(DrawnBounds, ArePointsWhereNothingIsDrawn) {
    SurfelTreeData data;
    data.header.bounds = {{0, 0, 0}, {1, 2, 3}};
    EXPECT_EQ(drawn_bounds(data.view(), false).hi, data.header.bounds.hi);
}

}  // namespace
}  // namespace slim
