#include "slim/edges/join_edges.h"

#include "slim/base/hash.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace slim::test {
namespace {

/// Short straight edges along y in a plate z <= 1 in the plane x = 0, in rows `apart` apart, with
/// gaps between them that are different everywhere; axes turned on by `turn`.
std::vector<TracedEdge> pieces_in_rows(std::size_t n_rows, std::size_t n_pieces, double apart,
                                       std::size_t turn) {
    const auto turned = [&](const Vec3d& v) {
        Vec3d out;
        for (std::size_t axis = 0; axis < 3; ++axis) out[(axis + turn) % 3] = v[axis];
        return out;
    };
    std::vector<TracedEdge> out;
    for (std::size_t row = 0; row < n_rows; ++row)
        for (std::size_t k = 0; k < n_pieces; ++k) {
            const double gap = 0.2 + 0.3 * unit_interval(keyed_hash(row, k));
            SharpEdge edge;
            edge.n_leaves = 1;
            for (const double y : {0.0, 0.5, 1 - gap})
                edge.points.push_back(
                    {turned({0, static_cast<double>(k) + y, apart * static_cast<double>(row)}),
                     to_float(turned({0, 1, 0})),
                     {to_float(turned({1, 0, 0})), to_float(turned({0, 0, 1}))}});
            if (keyed_hash(row, k, 1) % 2) {  // traced the other way
                std::reverse(edge.points.begin(), edge.points.end());
                for (EdgePoint& p : edge.points)
                    p.tangent = -p.tangent, std::swap(p.normal[0], p.normal[1]);
            }
            out.push_back({edge, {0.6, 0.6}});
        }
    return out;
}

TEST(JoinEdges, OfAPlateJoinItsRowsWhereverItFaces) {
    for (const std::size_t turn : {0u, 1u, 2u}) {
        const auto edges = joined_edges(pieces_in_rows(100, 30, 0.3, turn));
        ASSERT_EQ(edges.size(), 100u) << turn;
        for (const SharpEdge& edge : edges) {
            EXPECT_EQ(edge.n_leaves, 30u);
            EXPECT_EQ(edge.points.size(), 90u);
            EXPECT_FALSE(edge.closed);
            for (std::size_t i = 0; i + 1 < edge.points.size(); ++i)
                EXPECT_LT(length(edge.points[i + 1].point - edge.points[i].point), 0.6);
        }
    }
}

TEST(JoinEdges, OverMoreThanTheSmallerRadiusStayApart) {
    auto edges = pieces_in_rows(1, 2, 1, 0);
    EXPECT_EQ(joined_edges(edges).size(), 1u);
    edges[1].radius = {0.1, 0.1};
    EXPECT_EQ(joined_edges(edges).size(), 2u);
    std::swap(edges[0], edges[1]);
    EXPECT_EQ(joined_edges(edges).size(), 2u);
    EXPECT_TRUE(joined_edges({}).empty());
}

}  // namespace
}  // namespace slim::test
