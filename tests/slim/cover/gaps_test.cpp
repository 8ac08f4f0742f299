#include "slim/cover/gaps.h"

#include "slim/base/parallel.h"
#include "slim/cover/drawn_part.h"
#include "slim/cover/own_leaves.h"
#include "tests/slim/cover/cover_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace slim::test {
namespace {

constexpr double kStep = 0.3;  // between the leaves of a plane, as large as their radius

/// A plane of points over [-1, 1]^2 that face up, at a height.
PointBlock plane(double height) {
    PointBlock block = graph_points(4000, 1, 3, [&](double, double) { return height; });
    for (Vec3f& n : block.normal) n = {0, 0, 1};
    return along_curve(block);
}

/// Flat leaves over it, side by side, but for the one in the middle if it is to be missing.
std::vector<Surfel> leaves_over(double height, bool is_whole, double normal_z = 1) {
    std::vector<Surfel> out;
    for (int i = -3; i <= 3; ++i)
        for (int j = -3; j <= 3; ++j)
            if (is_whole || i != 0 || j != 0)
                out.push_back({{kStep * i, kStep * j, height},
                               0.32,
                               frame_from_normal(Vec3d{0, 0, normal_z}),
                               {},
                               2});
    return out;
}

std::vector<const Surfel*> pointers_to(const std::vector<Surfel>& leaves) {
    std::vector<const Surfel*> out;
    for (const Surfel& s : leaves) out.push_back(&s);
    return out;
}

TEST(Gaps, AMissingLeafIsFoundAndABorderIsNone) {
    const PointBlock block = plane(0);
    const PointTree tree = tree_of(block);
    const auto whole = leaves_over(0, true), holed = leaves_over(0, false);
    EXPECT_TRUE(find_gaps(tree, pointers_to(whole)).empty());
    const auto gaps = find_gaps(tree, pointers_to(holed));
    EXPECT_GT(gaps.size(), 3u);
    for (const Gap& gap : gaps) {
        EXPECT_LT(length(gap.place), kStep) << "only in the middle";
        EXPECT_LT(length(gap.place - tree.position(gap.point)), 0.1);
        EXPECT_DOUBLE_EQ(gap.normal.z, 1);
    }
    EXPECT_TRUE(is_drawn_at(whole[24], gaps.front().place, {0, 0, 1})) << "the missing one";
}

// A place that only the other side of a plate is drawn at shows its back.
TEST(Gaps, TheOtherSideOfAPlateClosesNone) {
    const PointBlock block = plane(0);
    const PointTree tree = tree_of(block);
    auto leaves = leaves_over(0, false);
    const std::size_t n_gaps = find_gaps(tree, pointers_to(leaves)).size();
    const auto below = leaves_over(-0.02, true, -1);
    leaves.insert(leaves.end(), below.begin(), below.end());
    EXPECT_GE(find_gaps(tree, pointers_to(leaves)).size(), n_gaps);
    EXPECT_GT(n_gaps, 0u);
}

// Where points are missing as well there is nothing to close.
TEST(Gaps, AHoleOfTheScanIsNone) {
    const PointBlock block = plane(0);
    PointBlock holed;
    for (std::size_t i = 0; i < block.size(); ++i)
        if (std::hypot(block.position[i].x, block.position[i].y) > 0.28) {
            holed.position.push_back(block.position[i]);
            holed.normal.push_back(block.normal[i]);
            holed.id.push_back(block.id[i]);
        }
    const PointTree tree = tree_of(holed);
    const auto leaves = leaves_over(0, false);
    EXPECT_TRUE(find_gaps(tree, pointers_to(leaves)).empty());
}

/// The leaves of a cover without those drawn at a place, and what own_leaves adds to them.
OwnLeavesFound own_at(const PointBlock& block, const CoverRules& rules, const Vec3d& place,
                      bool at_gaps, std::vector<Surfel>& others) {
    const Cover c = cover(block, rules);
    std::vector<FittedSurfel> left;
    for (const FittedSurfel& f : leaves_of(c))
        if (!is_drawn_at(f.surfel, place, {0, 0, 1})) left.push_back(f);
    others.clear();
    for (const FittedSurfel& f : left) others.push_back(f.surfel);
    const PointPyramid pyramid(block, box_of(block), 0, 1);
    const LeafMaker maker(block, rules, pyramid);
    LeafWork work;
    return own_leaves(pyramid.all(), block, rules, maker, source_of(left), {{}, {}, at_gaps}, work);
}

TEST(Gaps, AreTheSameForAnyNumberOfThreads) {
    const PointBlock block = block_of(sampled("sculpture", 20000));
    const CoverRules rules = rules_for(block, 0.01);
    std::vector<Surfel> leaves;
    for (const FittedSurfel& f : leaves_of(cover(block, rules))) leaves.push_back(f.surfel);
    for (std::size_t i = 0; i < leaves.size(); i += 7) leaves[i].support_radius *= 0.5;
    const PointTree tree = tree_of(block);
    const auto places = [&](int n_threads) {
        const ThreadLimit limit(n_threads);
        std::vector<std::array<double, 3>> out;
        for (const Gap& gap : find_gaps(tree, pointers_to(leaves)))
            out.push_back({gap.place.x, gap.place.y, gap.place.z});
        return out;
    };
    const auto one = places(1);
    EXPECT_GT(one.size(), 10u);
    EXPECT_EQ(one, places(4));
}

TEST(Gaps, AreClosedByLeavesOfTheirOwn) {
    PointBlock block = along_curve(
        graph_points(20000, 1, 1, [](double u, double v) { return 0.2 * (u * u + v * v); }));
    for (std::size_t i = 0; i < block.size(); ++i) {
        const Vec3d& p = block.position[i];
        block.normal[i] = to_float(normalized(Vec3d{-0.4 * p.x, -0.4 * p.y, 1}));
    }
    const CoverRules rules = rules_for(block, 1e-5);
    std::vector<Surfel> others;
    const PointTree tree = tree_of(block);
    EXPECT_TRUE(own_at(block, rules, {}, false, others).leaves.empty());
    const auto before = find_gaps(tree, pointers_to(others));
    ASSERT_GT(before.size(), 0u);
    const OwnLeavesFound own = own_at(block, rules, {}, true, others);
    EXPECT_GT(own.n_at_gaps, 0u);
    EXPECT_EQ(own.n_at_gaps, own.leaves.size());
    for (const CoveringSurfel& leaf : own.leaves) others.push_back(leaf.fitted.surfel);
    const auto is_closed = [&](const Gap& gap) {
        return std::any_of(others.begin(), others.end(), [&](const Surfel& s) {
            return is_drawn_at(s, gap.place, gap.normal);
        });
    };
    EXPECT_GT(std::count_if(before.begin(), before.end(), is_closed),
              static_cast<std::ptrdiff_t>(before.size() * 3 / 4));
    EXPECT_LT(find_gaps(tree, pointers_to(others)).size(), before.size() / 2);
}

}  // namespace
}  // namespace slim::test
