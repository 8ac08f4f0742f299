#include "slim/neighbors/point_pyramid.h"

#include "tests/slim/neighbors/neighbors_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

namespace slim::test {
namespace {

TEST(PointPyramid, ThinningsAreNestedAndKeepTheirShare) {
    const PointBlock block = random_cube(20000, 7);
    const PointPyramid pyramid(block, box_of(block), 3);
    ASSERT_GE(pyramid.n_levels(), 3u);
    EXPECT_EQ(pyramid.all().size(), block.size());
    double expected = 20000;
    for (std::size_t l = 0; l < pyramid.n_levels(); ++l) {
        const PointTree& tree = pyramid.level(l);
        EXPECT_NEAR(static_cast<double>(tree.size()), expected, 4 * std::sqrt(expected));
        std::set<std::uint32_t> here, prefix;
        for (std::size_t i = 0; i < tree.size(); ++i) here.insert(tree.source(i));
        for (std::size_t i = 0; i < pyramid.level_size(l); ++i)
            prefix.insert(pyramid.by_priority()[i]);
        EXPECT_EQ(here, prefix);
        expected *= 0.381966;
    }
}

TEST(PointPyramid, OfAShareGoesOnWithTheThinningsOfTheWhole) {
    const PointBlock block = random_cube(20000, 7);
    const PointPyramid whole(block, box_of(block), 3);
    PointBlock sample;
    for (std::size_t i = 0; i < block.size(); ++i) {
        if (!in_share(3, block.id[i], 0.25)) continue;
        sample.position.push_back(block.position[i]);
        sample.id.push_back(block.id[i]);
    }
    EXPECT_NEAR(static_cast<double>(sample.size()), 5000, 250);
    const PointPyramid part(sample, box_of(block), 3, 0.25);  // between the shares 0.38 and 0.15
    ASSERT_EQ(part.n_levels() + 1, whole.n_levels());
    for (std::size_t l = 1; l < part.n_levels(); ++l) {
        ASSERT_EQ(part.level_size(l), whole.level_size(l + 1));
        EXPECT_EQ(part.share(l), whole.share(l + 1));
        for (std::size_t i = 0; i < part.level_size(l); ++i)
            ASSERT_EQ(sample.id[part.level(l).source(i)],
                      block.id[whole.level(l + 1).source(i)]);
    }
}

// Of so many points, some fifty have priorities whose higher halves are alike, and those given
// twice have one priority.
TEST(PointPyramid, OrdersPointsByTheWholeOfTheirPriority) {
    PointBlock block;
    const std::size_t n = 600000;
    for (std::size_t i = 0; i < n; ++i) {
        block.position.push_back({static_cast<double>(i % 1000), static_cast<double>(i / 1000), 0});
        block.id.push_back(i < n - 50 ? i : i - 300);
    }
    const PointPyramid pyramid(block, box_of(block), 9);
    const std::vector<std::uint32_t>& order = pyramid.by_priority();
    ASSERT_EQ(order.size(), n);
    const auto priority = [&](std::uint32_t i) { return priority_of(9, block.id[i]); };
    std::size_t n_alike = 0;
    for (std::size_t i = 1; i < n; ++i) {
        const std::uint64_t before = priority(order[i - 1]), here = priority(order[i]);
        ASSERT_TRUE(before < here || (before == here && order[i - 1] < order[i])) << i;
        n_alike += before != here && before >> 32 == here >> 32;
    }
    EXPECT_GT(n_alike, 10u);
}

TEST(PointPyramid, IsTheSameForAnyOrderOfThePoints) {
    const PointBlock block = random_cube(5000, 8), shuffled = permuted(block, 4);
    ASSERT_NE(block.id, shuffled.id);
    const PointPyramid a(block, box_of(block), 1), b(shuffled, box_of(block), 1);
    ASSERT_EQ(a.n_levels(), b.n_levels());
    for (std::size_t l = 0; l < a.n_levels(); ++l) {
        ASSERT_EQ(a.level_size(l), b.level_size(l));
        for (std::size_t i = 0; i < a.level_size(l); ++i)
            ASSERT_EQ(block.id[a.level(l).source(i)], shuffled.id[b.level(l).source(i)]);
    }
    for (std::size_t i = 0; i < block.size(); ++i)
        ASSERT_EQ(block.id[a.by_priority()[i]], shuffled.id[b.by_priority()[i]]);
    const PointPyramid c(block, box_of(block), 2);
    EXPECT_NE(a.by_priority(), c.by_priority());
}

}  // namespace
}  // namespace slim::test
