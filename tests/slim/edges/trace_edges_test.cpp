#include "slim/edges/trace_edges.h"

#include "slim/base/hash.h"
#include "slim/base/parallel.h"
#include "slim/edges/edge_leaf.h"
#include "tests/raytrace/support/sharp_models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace slim::test {
namespace {

double length_of(const SharpEdge& edge) {
    double sum = 0;
    for (std::size_t i = 0; i + 1 < edge.points.size(); ++i)
        sum += length(edge.points[i + 1].point - edge.points[i].point);
    if (edge.closed) sum += length(edge.points.front().point - edge.points.back().point);
    return sum;
}

/// Distance from the nearest edge line of the cube [-1, 1]^3.
double off_cube_edges(const Vec3d& p) {
    double d[3] = {std::abs(std::abs(p.x) - 1), std::abs(std::abs(p.y) - 1),
                   std::abs(std::abs(p.z) - 1)};
    std::sort(d, d + 3);
    return std::hypot(d[0], d[1]);
}

std::vector<SharpEdge> edges_of(const std::vector<Surfel>& leaves, int degree = 2) {
    return trace_sharp_edges(flat_tree(leaves, degree).view(), false);
}

TEST(EdgeLeaf, FindsWherePlanesMeet) {
    const Surfel s =
        corner_surfel({1, 2, 3}, {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}, 0.5);
    const auto edge = nearest_on_edge(s, kSheetPairs[0], {0.2, -0.1, -0.4});
    ASSERT_TRUE(edge);
    EXPECT_LT(length(*edge - Vec3d{0, 0, -0.4}), 1e-6);
    EXPECT_TRUE(edge_shows(s, kSheetPairs[0], *edge));
    EXPECT_FALSE(edge_shows(s, kSheetPairs[0], {0, 0, 0.4}));  // cut off by the third
    const auto corners = corners_of(s);
    ASSERT_EQ(corners.size(), 1u);
    EXPECT_LT(length(corners[0].x), 1e-6);
    const Surfel flat = edge_surfel({}, {0, 0, 1}, {0, 0.01, 1}, 1);
    EXPECT_FALSE(nearest_on_edge(flat, kSheetPairs[0], {}));
}

TEST(EdgeLeaf, KnowsTheJoinOfEachPair) {
    const Surfel s = corner_surfel({}, {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}, 1,
                                   Join::max, Join::min);
    EXPECT_EQ(join_of_pair(*s.sharp, 0), Join::max);
    EXPECT_EQ(join_of_pair(*s.sharp, 1), Join::max);
    EXPECT_EQ(join_of_pair(*s.sharp, 2), Join::min);
    // max(x, min(y, z)): the edge y = z = 0 shows where x < 0.
    EXPECT_TRUE(edge_shows(s, kSheetPairs[2], {-0.5, 0, 0}));
    EXPECT_FALSE(edge_shows(s, kSheetPairs[2], {0.5, 0, 0}));
}

/// Four faces of an octahedron about a vertex at `center`.
Surfel peak(const Vec3d& center, double rho) {
    Surfel s = corner_surfel(center, {Vec3d{1, 0, 1}, Vec3d{0, 1, 1}, Vec3d{-1, 0, 1}}, rho);
    auto more = std::make_shared<SharpSheets>(*s.sharp);
    more->extra[2] = plane_sheet(Vec3d{0, -1, 1}), more->n_extra = 3;
    s.sharp = more;
    return s;
}

TEST(EdgeLeaf, APeakOfFourFacesHasItsCornerWhereAllMeet) {
    Surfel s = peak({1, 2, 3}, 0.5);
    EXPECT_EQ(n_sheet_pairs(s), 6u);
    EXPECT_EQ(kSheetPairs[3].a, 0u);
    EXPECT_EQ(kSheetPairs[5].b, 3u);
    const auto corners = corners_of(s);
    ASSERT_EQ(corners.size(), 1u);
    EXPECT_LT(length(corners[0].x), 1e-6);
    EXPECT_EQ(corners[0].sheets, 0b1111u);
    for (std::size_t pair = 0; pair < n_sheet_pairs(s); ++pair)
        EXPECT_EQ(join_of_pair(*s.sharp, pair), Join::max);
}

/// The end of a bar: its top and its end, and two sides that lie `half` rho from the centre.
Surfel bar_end(double rho, double half) {
    Surfel s = corner_surfel({}, {Vec3d{0, 0, 1}, Vec3d{1, 0, 0}, Vec3d{0, 1, 0}}, rho);
    auto more = std::make_shared<SharpSheets>(*s.sharp);
    more->extra[2] = plane_sheet({0, -1, 0}), more->n_extra = 3;
    more->extra[1].polynomial.a[0] = more->extra[2].polynomial.a[0] = half;
    s.sharp = more;
    return s;
}

TEST(EdgeLeaf, TheEndOfABarHasTwoCorners) {
    const auto corners = corners_of(bar_end(2, 0.4));
    ASSERT_EQ(corners.size(), 2u);
    EXPECT_LT(length(corners[0].x - Vec3d{0, 0.4, 0}), 1e-6);
    EXPECT_LT(length(corners[1].x - Vec3d{0, -0.4, 0}), 1e-6);
    EXPECT_TRUE(corners[0].is_of({0, 2}));
    EXPECT_FALSE(corners[0].is_of({0, 3}));
    EXPECT_EQ(corners_of(bar_end(2, 1.2)).size(), 0u);
}

TEST(TraceEdges, OfABarsEndRunFromCornerToCorner) {
    const auto edges = edges_of({bar_end(2, 0.4)});
    ASSERT_EQ(edges.size(), 5u);
    std::map<std::uint32_t, int> at_corner;
    for (const SharpEdge& edge : edges) {
        for (const std::uint32_t corner : edge.corner) ++at_corner[corner];
        if (edge.corner[0] == kNoCorner || edge.corner[1] == kNoCorner) continue;
        EXPECT_NEAR(length_of(edge), 2 * 2 * 0.4, 1e-6);
    }
    EXPECT_EQ(at_corner.size(), 3u);
    for (const auto& [corner, n] : at_corner) EXPECT_EQ(n, corner == kNoCorner ? 4 : 3);
}

TEST(TraceEdges, OfAPeakAreFourFromItsCorner) {
    const auto edges = edges_of({peak({}, 1)});
    ASSERT_EQ(edges.size(), 4u);
    for (const SharpEdge& edge : edges) {
        EXPECT_TRUE(edge.convex);
        EXPECT_GT(length_of(edge), 0.5);
    }
}

TEST(TraceEdges, OfACubeAreTwelveFromCornerToCorner) {
    const auto edges = edges_of(cube_leaves());
    ASSERT_EQ(edges.size(), 12u);
    std::map<std::uint32_t, int> at_corner;
    for (const SharpEdge& edge : edges) {
        EXPECT_TRUE(edge.convex);
        EXPECT_FALSE(edge.closed);
        EXPECT_EQ(edge.n_leaves, 8u);
        EXPECT_NEAR(length_of(edge), 2, 1e-5);
        for (const std::uint32_t corner : edge.corner) ++at_corner[corner];
        for (const EdgePoint& p : edge.points) {
            EXPECT_LT(off_cube_edges(p.point), 1e-6);
            EXPECT_NEAR(p.turn_deg(), 90, 1e-3);
        }
    }
    EXPECT_EQ(at_corner.size(), 8u);
    for (const auto& [corner, n] : at_corner) EXPECT_EQ(n, 3) << corner;
    EXPECT_FALSE(at_corner.contains(kNoCorner));
}

TEST(TraceEdges, TangentsRunAlongAndFacesKeepTheirSides) {
    for (const SharpEdge& edge : edges_of(cube_leaves()))
        for (std::size_t i = 0; i + 1 < edge.points.size(); ++i) {
            const EdgePoint &a = edge.points[i], &b = edge.points[i + 1];
            EXPECT_GT(dot(to_double(a.tangent), normalized(b.point - a.point)), 0.999);
            EXPECT_GT(dot(a.normal[0], b.normal[0]), 0.999f);
        }
}

TEST(TraceEdges, TellHollowFromConvex) {
    std::vector<Surfel> leaves;
    for (const double t : {0.0, 0.3, 0.6})
        leaves.push_back(edge_surfel({t, 0, 0}, {0, 0, 1}, {0, 1, 0}, 0.4, Join::min));
    const auto edges = edges_of(leaves);
    ASSERT_EQ(edges.size(), 1u);
    EXPECT_FALSE(edges[0].convex);
    // From the first core to the last.
    EXPECT_NEAR(length_of(edges[0]), 0.6 + 2 * 0.4 * kHitTrim, 2 * 0.04);
}

TEST(TraceEdges, OfARoundRimIsOneRing) {
    const auto edges = edges_of(rim_leaves(24, 0.35));
    ASSERT_EQ(edges.size(), 1u);
    EXPECT_TRUE(edges[0].closed);
    EXPECT_NEAR(length_of(edges[0]), 2 * std::numbers::pi, 0.01);
    for (const EdgePoint& p : edges[0].points) {
        EXPECT_NEAR(std::hypot(p.point.x, p.point.y), 1,
                    2e-4);  // the quadrics' own error in the core is 3e-4
        EXPECT_LT(std::abs(p.point.z), 1e-6);
        EXPECT_LT(std::abs(dot(p.tangent, to_float(p.point))), 0.02f);
    }
}

TEST(TraceEdges, AverageLeavesThatDisagree) {
    std::vector<Surfel> leaves = cube_leaves();
    constexpr double kOff = 4e-3;
    for (std::size_t i = 0; i < leaves.size(); ++i)
        if (leaves[i].n_sheets() == 2)
            for (std::size_t axis = 0; axis < 3; ++axis)
                leaves[i].center[axis] += kOff * (2 * unit_interval(keyed_hash(i, axis)) - 1);
    const auto edges = edges_of(leaves);
    EXPECT_EQ(edges.size(), 12u);
    double sq = 0, n = 0, steepest = 0;
    for (const SharpEdge& edge : edges)
        for (std::size_t i = 0; i + 1 < edge.points.size(); ++i) {
            sq += off_cube_edges(edge.points[i].point) * off_cube_edges(edge.points[i].point), ++n;
            const Vec3d along = normalized(edge.points[i + 1].point - edge.points[i].point);
            steepest = std::max(steepest, 1 - dot(along, to_double(edge.points[i].tangent)));
        }
    EXPECT_LT(std::sqrt(sq / n),
              0.9 * kOff * std::sqrt(2.0 / 3.0));  // of single leaves: kOff sqrt(2/3)
    EXPECT_LT(steepest, 5e-3);                                        // no zigzag: within 6 degrees
}

TEST(TraceEdges, AreJoinedOverASmallGapOnly) {
    const auto chain = [](double gap) {
        std::vector<Surfel> leaves;
        for (const double t : {-0.9, -0.6, -0.3, 0.0, gap, gap + 0.3, gap + 0.6})
            leaves.push_back(edge_surfel({t, 0, 0}, {0, 0, 1}, {0, 1, 0}, 0.4));
        return edges_of(leaves).size();
    };
    EXPECT_EQ(chain(0.3), 1u);
    EXPECT_EQ(chain(0.9), 1u);  // the cores end 0.32 apart
    EXPECT_EQ(chain(1.2), 2u);  // 0.62 apart, more than a radius
}

TEST(TraceEdges, BesideEachOtherStayApart) {
    // Two steps of a stair: four edges, two of each kind, between the same two directions.
    std::vector<Surfel> leaves;
    for (const double t : {0.0, 0.1, 0.2, 0.3})
        for (const double step : {0.0, 0.2}) {
            leaves.push_back(edge_surfel({t, step, step}, {0, 0, 1}, {0, -1, 0}, 0.15));
            leaves.push_back(
                edge_surfel({t, step + 0.2, step}, {0, 0, 1}, {0, -1, 0}, 0.15, Join::min));
        }
    const auto edges = edges_of(leaves);
    ASSERT_EQ(edges.size(), 4u);
    EXPECT_EQ(
        std::count_if(edges.begin(), edges.end(), [](const SharpEdge& e) { return e.convex; }), 2);
    for (const SharpEdge& edge : edges)
        EXPECT_NEAR(length_of(edge), 0.3 + 2 * 0.15 * kHitTrim, 0.04);
}

TEST(TraceEdges, OfLooseLeavesOnlyWhenAsked) {
    SurfelTreeData data = flat_tree(cube_leaves(), 2);
    for (TreeNode& node : data.nodes) node.flags |= kLoose;
    EXPECT_TRUE(trace_sharp_edges(data.view(), false).empty());
    EXPECT_EQ(trace_sharp_edges(data.view(), true).size(), 12u);
}

/// n cubes in a row, their edges' leaves off by a hundredth.
std::vector<Surfel> rough_cubes(std::size_t n) {
    std::vector<Surfel> leaves;
    for (std::size_t k = 0; k < n; ++k)
        for (Surfel s : cube_leaves()) {
            s.center += Vec3d{3.0 * static_cast<double>(k), 0, 0};
            for (std::size_t axis = 0; axis < 3; ++axis)
                s.center[axis] += 0.01 * (2 * unit_interval(keyed_hash(leaves.size(), axis)) - 1);
            leaves.push_back(s);
        }
    return leaves;
}

/// All that an edge is, in bytes.
std::vector<float> numbers_of(const std::vector<SharpEdge>& edges) {
    std::vector<float> out;
    for (const SharpEdge& e : edges) {
        out.insert(out.end(), {static_cast<float>(e.points.size()), static_cast<float>(e.n_leaves),
                               static_cast<float>(e.corner[0]), static_cast<float>(e.corner[1])});
        for (const EdgePoint& p : e.points)
            for (const Vec3f& v : {to_float(p.point), p.tangent, p.normal[0], p.normal[1]})
                out.insert(out.end(), {v.x, v.y, v.z});
    }
    return out;
}

TEST(TraceEdges, AreTheSameForAnyNumberOfThreads) {
    const SurfelTreeData model =
        flat_tree(rough_cubes(6), 2);  // more edges than are followed at once
    std::vector<float> expected;
    for (const int n : {1, 2, 5}) {
        const ThreadLimit limit(n);
        const auto edges = trace_sharp_edges(model.view(), false);
        if (expected.empty()) expected = numbers_of(edges);
        EXPECT_GE(edges.size(), 72u);
        EXPECT_EQ(numbers_of(edges), expected) << n;
    }
}

TEST(TraceEdges, OfManyPartsAreThoseOfEachAlone) {
    // What is followed at the same time takes nothing from each other.
    const auto all = edges_of(rough_cubes(5));
    std::size_t n = 0, n_leaves = 0;
    double sum = 0;
    for (std::size_t k = 0; k < 5; ++k) {
        std::vector<Surfel> one = rough_cubes(5);
        std::erase_if(one, [&](const Surfel& s) {
            return std::abs(s.center.x - 3.0 * static_cast<double>(k)) > 1.5;
        });
        for (const SharpEdge& edge : edges_of(one))
            ++n, n_leaves += edge.n_leaves, sum += length_of(edge);
    }
    std::size_t all_leaves = 0;
    double all_sum = 0;
    for (const SharpEdge& edge : all) all_leaves += edge.n_leaves, all_sum += length_of(edge);
    EXPECT_EQ(all.size(), n);
    EXPECT_EQ(all_leaves, n_leaves);
    EXPECT_NEAR(all_sum, sum, 1e-3 * sum);
}

TEST(TraceEdges, TellTheirProgressAndCanBeStopped) {
    const SurfelTreeData model = flat_tree(rough_cubes(4), 2);
    std::vector<std::size_t> told;
    std::size_t total = 0;
    trace_sharp_edges(model.view(), false,
                      [&](std::size_t done, std::size_t of) { told.push_back(done), total = of; });
    ASSERT_GT(told.size(), 40u);
    EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
    EXPECT_LE(told.back(), total);
    EXPECT_GT(told.back(), total / 2);
    struct Stop {};
    for (const std::size_t last : {std::size_t{0}, total / 2 + 1})
        EXPECT_THROW(trace_sharp_edges(model.view(), false,
                                       [&](std::size_t done, std::size_t) {
                                           if (done > last) throw Stop{};
                                       }),
                     Stop);
}

TEST(TraceEdges, OfASmoothModelAreNone) {
    EXPECT_TRUE(trace_sharp_edges(sphere_model(1, 100).view(), true).empty());
}

}  // namespace
}  // namespace slim::test
