#include "slim/base/block_list.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

namespace slim::test {
namespace {

TEST(BlockList, GivesBackWhatWasPutInInOrder) {
    // Blocks of 1 MiB: none, part of one, some full ones and a part.
    for (const std::size_t n : {0u, 1u, 1000u, 700000u}) {
        BlockList<std::size_t> list;
        for (std::size_t i = 0; i < n; ++i) list.push_back(3 * i);
        EXPECT_EQ(list.size(), n);
        const std::vector<std::size_t> all = list.take();
        ASSERT_EQ(all.size(), n);
        EXPECT_EQ(all.capacity(), n);
        for (std::size_t i = 0; i < n; ++i) ASSERT_EQ(all[i], 3 * i);
        EXPECT_EQ(list.size(), 0u);
        list.push_back(7);
        EXPECT_EQ(list.take(), std::vector<std::size_t>{7});
    }
}

TEST(BlockList, HoldsElementsLargerThanABlockAndThoseThatOnlyMove) {
    BlockList<std::array<char, 3 << 20>> large;
    large.push_back({'a'});
    large.push_back({'b'});
    EXPECT_EQ(large.take()[1][0], 'b');
    BlockList<std::unique_ptr<int>> owned;
    owned.push_back(std::make_unique<int>(5));
    EXPECT_EQ(*owned.take()[0], 5);
}

}  // namespace
}  // namespace slim::test
