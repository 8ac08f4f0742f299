#include "slim/normals/sign_merge.h"

#include "slim/base/hash.h"
#include "slim/normals/pair_weights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <utility>

namespace slim::test {
namespace {

TEST(SignMerge, AWrongVoteIsOutvotedWhereASpanningTreeFollowsIt) {
    // 0 and 1 are surely alike, 2 and 3 too; a single sure vote says that 1 and 2 are opposite,
    // three weaker ones between the two pairs that they are alike.
    const std::vector<SignVote> votes{{0, 1, 5}, {2, 3, 5}, {1, 2, -2},
                                      {0, 2, 1}, {0, 3, 1}, {1, 3, 1}};
    SignedForest forest = merge_by_votes(5, votes);
    for (std::uint32_t i = 1; i < 4; ++i) {
        EXPECT_EQ(forest.find(i).index, forest.find(0).index);
        EXPECT_EQ(forest.find(i).flipped, forest.find(0).flipped);
    }
    EXPECT_NE(forest.find(4).index, forest.find(0).index);  // nobody votes on it
}

TEST(PairWeights, FindsWhatAMapFindsAfterManyErasures) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, double> truth;
    PairWeights weights(64);
    std::size_t n_erased = 0;
    for (std::uint64_t i = 0; i < 20000; ++i) {
        const auto number = [&](std::uint64_t k) {
            return static_cast<std::uint32_t>(keyed_hash(k, i) % 24);
        };
        const auto [a, b] = std::minmax({number(1), number(2)});
        if (a == b) continue;
        const auto known = truth.find({a, b});
        const std::size_t at = weights.find(b, a);
        ASSERT_EQ(at != PairWeights::kNone, known != truth.end());
        if (at != PairWeights::kNone) {
            ASSERT_EQ(weights.weight(at), known->second);
        }
        if (known != truth.end() && number(3) % 2) {
            weights.erase(at);
            truth.erase(known);
            ++n_erased;
        } else if (known != truth.end() || truth.size() < 64) {
            weights.add(a, b, static_cast<double>(i));
            truth[{a, b}] += static_cast<double>(i);
        }
    }
    EXPECT_GT(n_erased, 1000u);
    std::size_t n = 0;
    weights.for_each([&](std::uint32_t a, std::uint32_t b, double weight) {
        EXPECT_EQ(weight, truth.at({a, b}));
        ++n;
    });
    EXPECT_EQ(n, truth.size());
    EXPECT_GT(n, 20u);
}

TEST(SignMerge, AddsUpTheVotesOnTheSameGroups) {
    std::vector<SignVote> votes{{1, 2, 3}, {0, 1, -1}, {1, 2, -1}, {0, 1, 0.5}};
    add_up(votes);
    ASSERT_EQ(votes.size(), 2u);
    EXPECT_EQ(votes[0].b, 1u);
    EXPECT_EQ(votes[0].weight, -0.5);
    EXPECT_EQ(votes[1].weight, 2);
}

TEST(SignMerge, OppositeGroupsHandOnWhatTheySayOfOthers) {
    const std::vector<SignVote> votes{{0, 1, -3}, {1, 2, 1}, {0, 2, 0.5}};
    SignedForest forest = merge_by_votes(3, votes);
    EXPECT_NE(forest.find(1).flipped, forest.find(0).flipped);
    EXPECT_NE(forest.find(2).flipped, forest.find(0).flipped);  // as 1, by 1 against 0.5
}

}  // namespace
}  // namespace slim::test
