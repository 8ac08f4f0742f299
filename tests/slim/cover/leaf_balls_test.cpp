#include "slim/cover/leaf_balls.h"

#include "slim/cover/leaves_along_curve.h"
#include "slim/cover/leaves_meeting.h"
#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace slim::test {
namespace {

/// Leaves in [-1, 1]^3 of radii up to 0.3.
std::vector<Surfel> some_leaves(std::size_t n) {
    std::vector<Surfel> out(n);
    for (std::size_t i = 0; i < n; ++i) {
        const auto at = [&](std::size_t k) { return random_at(11, 4 * i + k); };
        out[i].center = {at(0), at(1), at(2)};
        out[i].support_radius = 0.15 + 0.14 * at(3);
    }
    return out;
}

std::vector<const Surfel*> pointers_to(const std::vector<Surfel>& leaves) {
    std::vector<const Surfel*> out;
    for (const Surfel& s : leaves) out.push_back(&s);
    return out;
}

std::vector<const Surfel*> listed(const LeafBalls& balls) {
    std::vector<const Surfel*> out;
    for (std::size_t i = 0; i < balls.size(); ++i) out.push_back(balls[i]);
    return out;
}

TEST(LeafBalls, ThoseThatMeetABoxAreTheSameOnesInTheSameOrder) {
    for (const std::size_t n : {0u, 1u, 7u, 8u, 9u, 500u}) {
        SCOPED_TRACE(n);
        const std::vector<Surfel> leaves = some_leaves(n);
        const auto all = pointers_to(leaves);
        const LeafBalls balls(all);
        EXPECT_EQ(listed(balls), all);
        for (std::size_t k = 0; k < 50; ++k) {
            Bbox outer, inner;
            for (std::size_t i = 0; i < 6; ++i) {
                const auto at = [&](std::size_t axis) {
                    return random_at(12, 18 * k + 3 * i + axis);
                };
                outer.extend(Vec3d{at(0), at(1), at(2)});
                if (i == 2) inner = outer;
            }
            const LeafBalls about = balls.meeting(outer);
            EXPECT_EQ(listed(about), leaves_meeting(outer, all));
            EXPECT_EQ(listed(about.meeting(inner)), leaves_meeting(inner, all)) << "of the rest";
        }
    }
}

TEST(LeavesAlongCurve, AreTheSameOnesAndFollowEachOtherNearby) {
    const std::vector<Surfel> leaves = some_leaves(500);
    const auto all = pointers_to(leaves);
    auto ordered = leaves_along_curve(all, [](const Surfel& s) -> const Surfel& { return s; });
    const auto way = [](const std::vector<const Surfel*>& order) {
        double sum = 0;
        for (std::size_t i = 1; i < order.size(); ++i)
            sum += length(order[i]->center - order[i - 1]->center);
        return sum;
    };
    EXPECT_LT(way(ordered), 0.4 * way(all));
    std::sort(ordered.begin(), ordered.end());
    EXPECT_EQ(ordered, all);
}

}  // namespace
}  // namespace slim::test
