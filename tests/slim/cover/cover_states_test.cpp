#include "slim/cover/cover_states.h"

#include "slim/cover/leaf_maker.h"
#include "tests/slim/cover/cover_support.h"

#include <gtest/gtest.h>

namespace slim::test {
namespace {

/// What is found anew of a choice that a level left to a finer one.
RadiusChoice recalled(CoverStates& states, const RadiusChoice& choice) {
    LeafCandidate c;
    c.point = 7;
    c.choice = choice;
    states.remember(c);
    LeafCandidate again;
    again.point = 7;
    EXPECT_TRUE(states.recall(again));
    return again.choice;
}

TEST(CoverStates, AChoiceIsRecalledAsItWas) {
    const PointBlock block = graph_points(100, 1, 1, [](double, double) { return 0.0; });
    const CoverRules rules = rules_for(block, 0.01);
    CoverStates states(block, rules);
    LeafCandidate unknown;
    unknown.point = 8;
    EXPECT_FALSE(states.recall(unknown));

    RadiusChoice wide{0.25, 2};
    wide.limited = wide.widened = true;
    wide.finest = 0.125;
    const RadiusChoice found = recalled(states, wide);
    EXPECT_EQ(found.radius, 0.25);
    EXPECT_EQ(found.degree, 2);
    EXPECT_EQ(found.finest, 0.125);
    EXPECT_TRUE(found.limited);
    EXPECT_TRUE(found.widened);
    EXPECT_FALSE(found.forced);

    // Made smaller since: no longer what the larger ball's fit allowed, nor the top rung.
    RadiusChoice smaller = wide;
    smaller.radius = 0.125, smaller.widened = false;
    EXPECT_FALSE(recalled(states, smaller).widened);
}

TEST(CoverStates, AsManySheetsAreRecalledAsWereFound) {
    const PointBlock block = graph_points(100, 1, 1, [](double, double) { return 0.0; });
    const CoverRules rules = rules_for(block, 0.01);
    CoverStates states(block, rules);
    for (std::size_t n = 1; n <= kMostSheets; ++n) {
        LeafCandidate c;
        c.point = 7;
        c.choice = {0.25, 2};
        c.n_sheets = n;
        states.remember(c);
        LeafCandidate again;
        again.point = 7;
        ASSERT_TRUE(states.recall(again));
        EXPECT_EQ(again.n_sheets, n);
        EXPECT_EQ(again.choice.degree, 2);
    }
}

}  // namespace
}  // namespace slim::test
