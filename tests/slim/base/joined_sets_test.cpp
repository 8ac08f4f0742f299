#include "slim/base/joined_sets.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <utility>
#include <vector>

namespace slim {
namespace {

using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

JoinedSets joined(std::size_t n, const Pairs& pairs) {
    JoinedSets sets(n);
    for (const auto& [a, b] : pairs) sets.join(a, b);
    return sets;
}

TEST(JoinedSets, ASetIsKnownByItsLeastMemberInWhateverOrderItWasJoined) {
    const Pairs pairs{{7, 3}, {5, 7}, {2, 6}, {6, 5}, {1, 1}};
    const Pairs reversed(pairs.rbegin(), pairs.rend());
    for (const Pairs& order : {pairs, reversed}) {
        JoinedSets sets = joined(9, order);
        const JoinedSets& constant = sets;
        for (const std::uint32_t i : {2u, 3u, 5u, 6u, 7u}) {
            EXPECT_EQ(constant.find(i), 2u) << i;
            EXPECT_EQ(sets.find(i), 2u) << i;
        }
        for (const std::uint32_t i : {0u, 1u, 4u, 8u}) EXPECT_EQ(sets.find(i), i);
    }
}

TEST(JoinedSets, NumbersHaveNoGaps) {
    const auto [number, n] = joined(6, {{1, 4}, {5, 3}}).numbered();
    EXPECT_EQ(number, (std::vector<std::uint32_t>{0, 1, 2, 3, 1, 3}));
    EXPECT_EQ(n, 4u);
    EXPECT_EQ(JoinedSets(0).numbered().second, 0u);
}

}  // namespace
}  // namespace slim
