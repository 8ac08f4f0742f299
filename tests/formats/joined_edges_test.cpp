#include "formats/joined_edges.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace slim::test {
namespace {

/// A circle of radius 50 in n edges.
std::vector<SizedEdge> rim(std::size_t n, double size) {
    const auto at = [n](std::size_t i) {
        const double angle =
            2 * std::numbers::pi * static_cast<double>(i % n) / static_cast<double>(n);
        return Vec3d{50 * std::cos(angle), 50 * std::sin(angle), 0};
    };
    std::vector<SizedEdge> out;
    for (std::size_t i = 0; i < n; ++i)  // wound both ways
        out.push_back(i % 2 ? SizedEdge{at(i), at(i + 1), size}
                            : SizedEdge{at(i + 1), at(i), size});
    return out;
}

TEST(JoinedEdges, ARimOfManyEdgesIsAFewAndAsNear) {
    const auto many = rim(8000, 2);
    const auto few = joined_edges(many);
    EXPECT_GE(few.size(), 20u);
    EXPECT_LE(few.size(), 80u);
    for (const Vec3d& p : {Vec3d{50, 0, 0}, {0, 49, 0}, {-30, 30, 5}, {0, 0, 0}}) {
        const auto size = [&p](const std::vector<SizedEdge>& edges) {
            double least = std::numeric_limits<double>::infinity();
            for (const SizedEdge& e : edges) least = std::min(least, e.size_at(p));
            return least;
        };
        EXPECT_NEAR(size(few), size(many), SizedEdge::kGrowth * 0.15 * 2 + 1e-3);
    }
}

TEST(JoinedEdges, CornersSizesAndMeetingsOfThreeStay) {
    const SizedEdge a{{0, 0, 0}, {1, 0, 0}, 1}, b{{1, 0, 0}, {2, 0, 0}, 1};
    const std::vector<SizedEdge> straight{a, b};
    ASSERT_EQ(joined_edges(straight).size(), 1u);
    EXPECT_EQ(joined_edges(straight)[0].to, b.to);
    const std::vector<SizedEdge> corner{a, {{1, 0, 0}, {1, 1, 0}, 1}};
    EXPECT_EQ(joined_edges(corner).size(), 2u);
    const std::vector<SizedEdge> sizes{a, {b.from, b.to, 2}};
    EXPECT_EQ(joined_edges(sizes).size(), 2u);
    const std::vector<SizedEdge> three{a, b, {{1, 0, 0}, {1, 1, 0}, 1}};
    EXPECT_EQ(joined_edges(three).size(), 3u);
    EXPECT_TRUE(joined_edges({}).empty());
}

}  // namespace
}  // namespace slim::test
