#include "slim/cover/needless_leaves.h"

#include "slim/base/parallel.h"
#include "slim/cover/drawn_part.h"
#include "slim/cover/surfel_fit.h"
#include "tests/slim/cover/cover_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numbers>
#include <vector>

namespace slim::test {
namespace {

constexpr double kRadius = 0.4;

/// Points of a plane; leaves 0.2 apart on it, or nearer to each other, that cover it.
struct Tiling {
    PointBlock block = along_curve(graph_points(4000, 1, 3, [](double, double) { return 0.0; }));
    PointTree tree = tree_of(block);
    std::vector<std::vector<FittedSurfel>> leaves{1};
    std::vector<std::uint32_t> centers;
    std::vector<BlendResidual> blend = std::vector<BlendResidual>(block.size());
    std::vector<std::uint8_t> n_drawn = std::vector<std::uint8_t>(block.size());
    NeedlessRules rules{1e-6, 1e-3, 0.1};
    std::function<bool(const Vec3d&)> owns;  ///< leaves that others here may rely on
    std::vector<std::uint64_t> removed;

    void add(Vec3d near, double height = 0) {
        std::uint32_t at = 0;
        for (std::uint32_t i = 0; i < block.size(); ++i)
            if (sq_length(block.position[i] - near) < sq_length(block.position[at] - near)) at = i;
        FittedSurfel f;
        f.surfel = {block.position[at], kRadius, frame_from_normal(Vec3d{0, 0, 1}), {}, 2};
        f.surfel.polynomial.a[0] = height / kRadius;
        f.fit_error = 0.01;
        f.flags = kLeaf, f.point_id = block.id[at];
        BallPoints<double> ball;
        for (const Covered& p : cover_again(tree, f, rules.noise_variance, ball).covered) {
            const LeafShare s = LeafShares(f.surfel).of(p);
            blend[s.point].weight += s.weight, blend[s.point].height += s.height;
            const bool stays = !owns || owns(f.surfel.center);
            n_drawn[s.point] =
                static_cast<std::uint8_t>(n_drawn[s.point] + (stays && s.is_drawn));
        }
        leaves.front().push_back(f);
        centers.push_back(at);
    }
    void tile(double apart) {
        for (Vec3f& n : block.normal) n = {0, 0, 1};
        for (double y = -1; y <= 1; y += apart)
            for (double x = -1; x <= 1; x += apart) add({x, y, 0});
    }
    void remove() {
        remove_needless(tree, rules, centers, blend, n_drawn, leaves,
                        [&](const FittedSurfel& f, std::size_t number) {
                            EXPECT_EQ(f.point_id, block.id[centers[number]]);
                            removed.push_back(f.point_id);
                        });
    }
};

TEST(NeedlessLeaves, GoWhereOthersDrawTheirPoints) {
    Tiling t;
    t.tile(0.2);
    const std::vector<std::uint8_t> before = t.n_drawn;
    const std::size_t n = t.leaves.front().size();
    t.remove();
    EXPECT_GT(t.removed.size(), n / 3);
    EXPECT_EQ(t.leaves.front().size() + t.removed.size(), n);
    for (std::size_t i = 0; i < t.block.size(); ++i) {
        const auto draws = [&](const FittedSurfel& f) {
            return sq_length(f.surfel.center - t.block.position[i]) <
                   kTrim * kTrim * kRadius * kRadius;
        };
        if (before[i] == 0) continue;
        EXPECT_TRUE(std::any_of(t.leaves.front().begin(), t.leaves.front().end(), draws)) << i;
        EXPECT_GE(t.blend[i].weight, 0.059) << i;
    }
}

TEST(NeedlessLeaves, StayWhereNoOtherDrawsAPoint) {
    Tiling t;
    t.tile(0.55);
    t.remove();
    EXPECT_TRUE(t.removed.empty());
}

// One that stands apart from the points is the first to go; one whose neighbours do so is needed.
TEST(NeedlessLeaves, ThoseThatTheBlendIsBetterWithoutGoFirst) {
    Tiling t;
    t.tile(0.25);
    t.add({0.1, 0.1, 0}, 0.03);
    const std::uint64_t apart = t.block.id[t.centers.back()];
    t.remove();
    ASSERT_FALSE(t.removed.empty());
    EXPECT_EQ(t.removed.front(), apart);
}

// What two slices take away, each relying on leaves of its own alone, opens nothing between them.
TEST(NeedlessLeaves, OfTwoSlicesRelyOnNoneOfTheOthers) {
    const auto is_left = [](const Vec3d& p) { return p.x < 0.1; };
    const auto is_right = [&](const Vec3d& p) { return !is_left(p); };
    Tiling whole, left, right;
    whole.tile(0.2);
    left.owns = left.rules.owns = is_left, right.owns = right.rules.owns = is_right;
    left.tile(0.2), right.tile(0.2);
    left.remove(), right.remove();
    EXPECT_FALSE(left.removed.empty());
    EXPECT_FALSE(right.removed.empty());
    const auto stays = [&](const FittedSurfel& f) {
        const auto& removed = is_left(f.surfel.center) ? left.removed : right.removed;
        return std::count(removed.begin(), removed.end(), f.point_id) == 0;
    };
    for (std::size_t i = 0; i < whole.block.size(); ++i) {
        const auto draws = [&](const FittedSurfel& f) {
            return stays(f) && sq_length(f.surfel.center - whole.block.position[i]) <
                                   kTrim * kTrim * kRadius * kRadius;
        };
        const auto& leaves = whole.leaves.front();
        EXPECT_TRUE(whole.n_drawn[i] == 0 || std::any_of(leaves.begin(), leaves.end(), draws)) << i;
    }
}

TEST(NeedlessLeaves, StayWhereTheBlendWouldBeWorse) {
    Tiling t;
    for (Vec3f& n : t.block.normal) n = {0, 0, 1};
    for (const double x : {-0.15, 0.15})
        for (const double y : {-0.15, 0.15}) t.add({x, y, 0}, 0.02);
    t.add({0, 0, 0});
    const std::uint64_t right = t.block.id[t.centers.back()];
    t.rules.most_worse = 1e-6;
    t.remove();
    EXPECT_EQ(std::count(t.removed.begin(), t.removed.end(), right), 0);
}

// False parabolic lines ran over a noisy cylinder of cubics without them.
TEST(NeedlessLeaves, AreNoneWherePointsAreNoisy) {
    const PointBlock block = block_of(sampled("torus", 5000));
    CoverRules rules = rules_for(block, 0.02);
    rules.refits = true;
    EXPECT_GT(cover(block, rules).counts.needless, 0u);
    rules.typical_variance = 0.1 * 0.1 * (4 * std::numbers::pi * std::numbers::pi * 0.35) / 5000;
    EXPECT_EQ(cover(block, rules).counts.needless, 0u);
}

TEST(NeedlessLeaves, CountsAreOfThoseThatStay) {
    const PointBlock block = block_of(sampled("torus", 20000));
    CoverRules rules = rules_for(block, 0.02);
    rules.refits = true;
    const Cover c = cover(block, rules);
    EXPECT_GT(c.counts.needless, c.counts.leaves / 50);
    EXPECT_EQ(c.counts.leaves, leaves_of(c).size());
    EXPECT_EQ(c.counts.degrees[2], c.counts.leaves);
    std::uint64_t causes = 0, limited = 0;
    for (const std::uint64_t n : c.counts.fallbacks) causes += n;
    for (const FittedSurfel& s : leaves_of(c)) limited += (s.flags & kLimited) != 0;
    EXPECT_EQ(causes, c.counts.leaves);
    EXPECT_GE(limited, c.counts.contrary);
}

}  // namespace
}  // namespace slim::test
