#include "slim/tree/drawn_bounds.h"

#include "slim/tree/tree_builder.h"

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
    std::vector<std::uint32_t> visited;
    const SurfelTreeData data = model(sheet(40, 0), points);
    const Bbox box = drawn_bounds(data.view(), false, &visited);
    constexpr double kRim = 0.5 / 40 + 1e-6;  // of a leaf, which reaches beyond its points
    EXPECT_NEAR(box.lo.x, 0, kRim);
    EXPECT_EQ(box.hi.x, 1);
    EXPECT_EQ(box.lo.y, 0);
    EXPECT_NEAR(box.hi.y, 1, kRim);
    EXPECT_NEAR(box.lo.z, 0, 1e-6);
    EXPECT_NEAR(box.hi.z, 0, 1e-6);
    EXPECT_FALSE(visited.empty());
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
