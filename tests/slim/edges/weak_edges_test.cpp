#include "slim/edges/weak_edges.h"

#include "tests/raytrace/support/sharp_models.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace slim::test {
namespace {

SharpEdge edge_of(std::size_t n_leaves, double turn_deg) {
    const double a = turn_deg * std::numbers::pi / 180;
    const std::array<Vec3f, 2> normal{to_float(Vec3d{0, 0, 1}),
                                      to_float(Vec3d{std::sin(a), 0, std::cos(a)})};
    SharpEdge edge;
    edge.n_leaves = n_leaves;
    edge.points = {{{0, 0, 0}, {0, 1, 0}, normal}, {{0, 0.1, 0}, {0, 1, 0}, normal}};
    return edge;
}

std::vector<double> turns_left(double roughness) {
    std::vector<double> out;
    for (const SharpEdge& e : without_weak_edges(
             {edge_of(1, 30), edge_of(2, 20), edge_of(1, 60), edge_of(9, 90)}, roughness))
        out.push_back(std::round(static_cast<double>(e.points[0].turn_deg())));
    return out;
}

TEST(WeakEdges, NoiseTakesWhatOneLeafAloneShows) {
    EXPECT_EQ(turns_left(0), (std::vector<double>{30, 20, 60, 90}));
    EXPECT_EQ(turns_left(0.03), (std::vector<double>{30, 20, 60, 90}));  // 12 * 0.03 are 21 degrees
    EXPECT_EQ(turns_left(0.065), (std::vector<double>{20, 60, 90}));
    EXPECT_EQ(turns_left(1),
              (std::vector<double>{20, 60, 90}));  // never one of 45 degrees and more
}

TEST(WeakEdges, RoughnessIsThatOfTheSharpLeavesInTheMiddle) {
    std::vector<Surfel> leaves;
    for (const double x : {0.0, 3.0, 6.0})
        leaves.push_back(edge_surfel({x, 0, 0}, {0, 0, 1}, {1, 0, 1}, 0.5));
    SurfelTreeData data = flat_tree(leaves, 2);
    EXPECT_EQ(sharp_roughness(flat_tree({sphere_surfel({0, 0, 1}, 1, 0.3, 2)}, 2).view(), false),
              0);
    std::size_t k = 0;
    for (TreeNode& node : data.nodes)
        if (node.is_leaf()) node.fit_error = std::array{0.01f, 0.03f, 0.2f}[k++];
    ASSERT_EQ(k, 3u);
    EXPECT_NEAR(sharp_roughness(data.view(), false), 0.06, 1e-6);
}

}  // namespace
}  // namespace slim::test
