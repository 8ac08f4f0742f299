#include "slim/neighbors/key_sort.h"

#include "slim/base/parallel.h"
#include "slim/neighbors/nearest.h"
#include "slim/neighbors/point_tree.h"
#include "tests/slim/neighbors/neighbors_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <numeric>
#include <span>
#include <vector>

namespace slim::test {
namespace {

/// By key, items of equal keys in their order, on several threads.
void expect_sorts(KeyedIndices items) {
    KeyedIndices expected = items;
    std::stable_sort(expected.begin(), expected.end(),
                     [](const auto& a, const auto& b) { return a.key < b.key; });
    const ThreadLimit limit(3);
    sort_by_key(items);
    EXPECT_TRUE(items == expected);
    sort_by_key(items);
    EXPECT_TRUE(items == expected);
}

TEST(KeySort, SortsByKeyAndKeepsTheOrderOfEqualOnes) {
    for (const std::size_t n : {0u, 1u, 100u, 5000u, 200000u})
        for (const std::uint64_t mask : {~0ull, 0xffull, 0xff00ff0000ull, 0ull}) {
            SCOPED_TRACE(testing::Message() << n << " items, mask " << mask);
            KeyedIndices items(n);
            for (std::uint32_t i = 0; i < n; ++i) items[i] = {keyed_hash(3, i) & mask, i};
            expect_sorts(std::move(items));
        }
}

TEST(KeySort, SortsACrowdInOneCornerOfTheRange) {
    KeyedIndices items(400000);
    for (std::uint32_t i = 0; i < items.size(); ++i) {
        const std::uint64_t key = keyed_hash(5, i) >> 1;
        items[i] = {i % 8 == 0 ? key : key >> 20, i};
    }
    expect_sorts(std::move(items));
}

TEST(KeySort, SortsNumbers) {
    for (const std::size_t n : {0u, 1u, 5000u, 300000u})
        for (const std::uint64_t mask : {~0ull, 0xfff00000ffffull}) {
            UnfilledVector<std::uint64_t> numbers(n);
            for (std::uint32_t i = 0; i < n; ++i) numbers[i] = keyed_hash(4, i) & mask;
            UnfilledVector<std::uint64_t> expected = numbers;
            std::sort(expected.begin(), expected.end());
            const ThreadLimit limit(3);
            sort_numbers(numbers);
            EXPECT_TRUE(numbers == expected) << n;
        }
}

/// Keys of which the highest bits of some are alike (few, many, all), with equal ones among them.
TEST(OrderByKey, IsByTheWholeKeyThenByIndexOrAsTold) {
    for (const std::size_t n : {0u, 1u, 2u, 5000u, 300000u})
        for (const std::uint64_t mask :
             {~0ull, ~0ull >> 1, 0xfffff00000000fffull, 0x8000000000ffffffull, 0xfffull, 0ull}) {
            SCOPED_TRACE(testing::Message() << n << " keys, mask " << mask);
            UnfilledVector<std::uint64_t> keys(n);
            for (std::uint32_t i = 0; i < n; ++i) keys[i] = keyed_hash(6, i - i % 3 / 2) & mask;
            std::vector<std::uint32_t> expected(n);
            std::iota(expected.begin(), expected.end(), 0u);
            const auto by_key = [&](std::uint32_t a, std::uint32_t b) { return keys[a] < keys[b]; };
            std::stable_sort(expected.begin(), expected.end(), by_key);
            const ThreadLimit limit(3);
            EXPECT_EQ(order_by_key(keys), expected);
            const auto latest_first = [&](std::uint32_t a, std::uint32_t b) {
                return keys[a] != keys[b] ? keys[a] < keys[b] : a > b;
            };
            std::sort(expected.begin(), expected.end(), latest_first);
            EXPECT_EQ(order_by_key(keys,
                                   [](std::span<std::uint32_t> row) {
                                       std::sort(row.begin(), row.end(), std::greater());
                                   }),
                      expected);
        }
}

TEST(SortAlongCurve, PutsRepeatsSideBySideWhateverTheOrderTheyCameIn) {
    PointBlock block = random_cube(3000, 12);
    for (std::size_t i = 0; i < 1000; ++i) block.position[i] = block.position[i % 70];
    for (std::size_t i = 0; i < block.size(); ++i)
        block.scan.push_back(static_cast<std::uint16_t>(block.id[i] % 7));
    PointBlock other = permuted(block, 5);
    for (const std::uint64_t id : other.id)
        other.scan.push_back(static_cast<std::uint16_t>(id % 7));
    const Bbox box = box_of(block);
    sort_along_curve(block, box);
    sort_along_curve(other, box);
    EXPECT_EQ(block.position, other.position);
    EXPECT_EQ(block.normal, other.normal);
    EXPECT_EQ(block.id, other.id);
    EXPECT_EQ(block.scan, other.scan);
    const std::vector<std::uint32_t> order = morton_order(block, box);
    EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
    const NearestSearch search(block.position);
    std::size_t repeats = 0;
    for (std::size_t i = 0; i < block.size(); ++i) repeats += search.is_repeat(i);
    EXPECT_EQ(repeats, 930u);
}

}  // namespace
}  // namespace slim::test
