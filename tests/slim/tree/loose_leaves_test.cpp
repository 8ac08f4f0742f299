#include "slim/tree/loose_leaves.h"

#include "slim/base/parallel.h"
#include "slim/tree/ball_index.h"
#include "slim/tree/tree_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

namespace slim::test {
namespace {

/// Leaves of one size whose balls overlap as those of a cover do.
constexpr double kRho = 1, kStep = 0.8;
constexpr double kDensity = 100;  // points to rho^2

FittedSurfel leaf(const Vec3d& center, const Vec3d& normal, double rho = kRho,
                  double density = kDensity) {
    FittedSurfel f;
    f.surfel = {center, rho, frame_from_normal(round_normal(normal)), {}, 2};
    f.level = 2;
    f.flags = kLeaf;
    f.n_points = static_cast<std::uint32_t>(std::lround(density * rho * rho));
    return f;
}

using Leaves = std::vector<FittedSurfel>;

/// n x n leaves in the plane of u and v from a corner on.
Leaves sheet(const Vec3d& corner, const Vec3d& u, const Vec3d& v, int n, double rho = kRho,
             double density = kDensity) {
    Leaves out;
    for (int i = 0; i < n; ++i)
        for (int k = 0; k < n; ++k)
            out.push_back(
                leaf(corner + (u * i + v * k) * (kStep * rho), cross(u, v), rho, density));
    return out;
}

Leaves floor_of(int n) { return sheet({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, n); }

Leaves operator+(Leaves a, const Leaves& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

struct Marked {
    SurfelTreeData data;
    LooseCounts counts;

    /// Centres of the loose leaves.
    std::vector<Vec3d> loose() const {
        std::vector<Vec3d> out;
        for (std::size_t i = 0; i < data.nodes.size(); ++i)
            if (data.nodes[i].is_leaf() && data.nodes[i].is_loose())
                out.push_back(data.view().center(i));
        return out;
    }
};

Marked mark(const Leaves& leaves, double noise = 0) {
    Marked out;
    TreeCounts counts;
    ModelHeader header;
    header.degree = 2;
    header.noise_variance = noise * noise;
    out.data = build_tree(leaves, header, counts);
    out.counts = mark_loose(out.data);
    EXPECT_EQ(out.loose().size(), out.counts.loose());
    return out;
}

TEST(LooseLeaves, ADiscOfFewPointsBesideASurfaceIsLoose) {
    const Vec3d at{6, 6, 0.3};
    const Marked m = mark(floor_of(16) + Leaves{leaf(at, {1, 0, 0.3}, 0.5, 0.3 * kDensity)});
    ASSERT_EQ(m.loose().size(), 1u);
    EXPECT_LT(length(m.loose()[0] - at), 1e-6);
    EXPECT_EQ(m.counts.beside, 1u);
    EXPECT_EQ(m.counts.pieces, 2u);
}

TEST(LooseLeaves, OneThatAgreesWithItsNeighboursIsNot) {
    EXPECT_TRUE(mark(floor_of(16) + Leaves{leaf({6, 6, 0.05}, {0.1, 0, 1}, 0.5, 0.3 * kDensity)})
                    .loose().empty());
}

TEST(LooseLeaves, PartsAsDenseAsTheSurfaceBesideThemStay) {
    // A small step, a chip of an edge: few leaves that agree with nothing, but of all the points
    // there should be.
    EXPECT_TRUE(
        mark(floor_of(16) + Leaves{leaf({6, 6, 0.3}, {1, 0, 0.3}, 0.5, kDensity)}).loose().empty());
}

TEST(LooseLeaves, NotIfTheyAreHardlyLargerThanTheNoise) {
    const Leaves chip{leaf({20, 20, 0.08}, {1, 0, 0.3}, 0.1, kDensity * 60)};
    EXPECT_TRUE(mark(floor_of(64) + chip, 0.1 / 10).loose().empty());
    const Marked m = mark(floor_of(64) + chip, 0.1 / 8);
    EXPECT_EQ(m.loose().size(), 1u);
    EXPECT_EQ(m.counts.in_noise, 1u);
}

TEST(LooseLeaves, StraysInNoiseThatTouchOnlyEachOtherAreLoose) {
    // Three that disagree with each other, of which the last touches nothing else.
    const Leaves strays{leaf({20, 20, 0.08}, {1, 0, 0.3}, 0.1, kDensity * 20),
                        leaf({20, 20, 0.22}, {0, 1, 0.3}, 0.1, kDensity * 20),
                        leaf({20, 20, 0.36}, {1, 0, -0.3}, 0.1, kDensity * 20)};
    EXPECT_EQ(mark(floor_of(64) + strays, 0.1 / 8).counts.in_noise, 3u);
    EXPECT_TRUE(mark(floor_of(64) + strays, 0.1 / 10).loose().empty());
}

TEST(LooseLeaves, PartsInNoiseStayIfTheyAreMoreThanACrumbOfTheModel) {
    // A thin plate's side: leaves of a few points in noise, but a thousandth of the surface.
    const Leaves side{leaf({3, 3, 0.3}, {1, 0, 0.3}, 0.5, kDensity)};
    EXPECT_TRUE(mark(floor_of(16) + side, 0.5 / 8).loose().empty());
}

TEST(LooseLeaves, NoSheetOfTwoCloseOnesIsLoose) {
    const Leaves both =
        floor_of(12) + sheet({0, 0, 0.4}, {0, 1, 0}, {1, 0, 0}, 4, kRho, 0.4 * kDensity);
    EXPECT_TRUE(mark(both).loose().empty());
}

TEST(LooseLeaves, AWallOfFewPointsOnAFloorStays) {
    // 12 leaves of a quarter of the points: one by one they would be loose.
    Leaves wall;
    for (int i = 0; i < 12; ++i)
        wall.push_back(leaf({2 + kStep * i, 6, 0.6}, {0, 1, 0}, kRho, 0.25 * kDensity));
    EXPECT_TRUE(mark(floor_of(20) + wall).loose().empty());
    EXPECT_EQ(mark(floor_of(20) + Leaves{wall[6]}).loose().size(), 1u);
}

TEST(LooseLeaves, BothSidesOfASharpEdgeStay) {
    const Leaves box = floor_of(16) + sheet({0, 0, -0.2}, {0, 0, -1}, {0, 1, 0}, 16);
    const Marked m = mark(box);
    EXPECT_TRUE(m.loose().empty());
    EXPECT_EQ(m.counts.pieces, 2u);
}

TEST(LooseLeaves, ASharpLeafBelongsToItsFaces) {
    FittedSurfel edge = leaf({0, 6, 0}, {0, 0, 1}, kRho, 0.3 * kDensity);
    auto more = std::make_shared<SharpSheets>();
    more->n_extra = 1;
    more->extra[0].frame = frame_from_normal(round_normal({-1, 0, 0}));
    edge.surfel.sharp = more;
    const Leaves box = floor_of(16) + sheet({0, 0, 0}, {0, 1, 0}, {0, 0, -1}, 16);
    const Marked m = mark(box + Leaves{edge});
    EXPECT_TRUE(m.loose().empty());
    EXPECT_EQ(m.counts.pieces, 1u);
}

TEST(LooseLeaves, ASmallObjectFarFromAllElseStays) {
    EXPECT_TRUE(mark(floor_of(16) + Leaves{leaf({60, 0, 0}, {0, 1, 0}, 0.3)}).loose().empty());
    // As far as a scanner sees it: half the points.
    EXPECT_TRUE(mark(floor_of(16) + Leaves{leaf({60, 0, 0}, {0, 1, 0}, kRho, 0.5 * kDensity)})
                    .loose().empty());
}

TEST(LooseLeaves, ASparseObjectOfSeveralLeavesStays) {
    // Its sides agree with nothing, and each by itself would be a disc of strays.
    const auto side = [](const Vec3d& normal) {
        return leaf(Vec3d{60, 0, 0} + normal * 0.7, normal, 1, 0.1 * kDensity);
    };
    const Leaves object{side({1, 0, 0}),  side({0, 1, 0}),  side({0, 0, 1}),
                        side({-1, 0, 0}), side({0, -1, 0}), side({0, 0, -1})};
    EXPECT_TRUE(mark(floor_of(16) + object).loose().empty());
    EXPECT_EQ(mark(floor_of(16) + Leaves{object[0]}).loose().size(), 1u);
}

TEST(LooseLeaves, ALargeDiscOfAFewStraysIsLooseAnywhere) {
    const Marked m = mark(floor_of(16) + Leaves{leaf({60, 0, 0}, {0, 1, 0}, 2, 0.03 * kDensity)});
    EXPECT_EQ(m.loose().size(), 1u);
    EXPECT_EQ(m.counts.astray, 1u);
}

TEST(LooseLeaves, CloudsOfAFewPointsAreDrawn) {
    for (int n : {1, 2, 3, 9}) {
        Leaves few;
        for (int i = 0; i < n; ++i)
            few.push_back(leaf({3.0 * i, 0, 0}, {0, std::sin(i), std::cos(i)}, 1, 1));
        EXPECT_TRUE(mark(few).loose().empty()) << n;
    }
}

TEST(LooseLeaves, InternalSurfelsAboveNothingElseAreLooseToo) {
    FittedSurfel near = leaf({6, 6, 0}, {0, 0, 1}, 6), far = leaf({60, 0, 0}, {0, 0, 1}, 6);
    near.level = far.level = 1;
    near.flags = far.flags = 0;
    const Marked m =
        mark(floor_of(16) + Leaves{leaf({60, 0, 0}, {0, 1, 0}, 2, 0.03 * kDensity), near, far});
    std::size_t loose = 0, internal = 0;
    for (std::size_t i = 1; i < m.data.nodes.size(); ++i) {
        if (m.data.nodes[i].is_leaf()) continue;
        ++internal;
        if (!m.data.nodes[i].is_loose()) continue;
        ++loose;
        EXPECT_GT(m.data.view().center(i).x, 50);
    }
    EXPECT_EQ(internal, 2u);
    EXPECT_EQ(loose, 1u);
    EXPECT_FALSE(m.data.nodes[0].is_loose());
}

TEST(LooseLeaves, TheyStillSupportTheirPoints) {
    const Vec3d at{60, 0, 0};
    const Marked m = mark(floor_of(16) + Leaves{leaf(at, {0, 1, 0}, 2, 0.03 * kDensity)});
    ASSERT_EQ(m.counts.loose(), 1u);
    std::vector<const Surfel*> supporters;
    BallIndex(m.data.view()).supporters(at, supporters);
    EXPECT_EQ(supporters.size(), 1u);
}

TEST(LooseLeaves, TheSameForAnyNumberOfThreadsAndOrderOfLeaves) {
    Leaves scene = floor_of(40);
    for (int i = 0; i < 60; ++i)
        scene.push_back(leaf({0.5 * i, 0.4 * i, 0.3 * std::sin(i)}, {std::cos(i), std::sin(i), 0.3},
                             0.3 + 0.01 * i, (0.1 + 0.02 * i) * kDensity));
    const auto flags = [&](int threads) {
        const ThreadLimit limit(threads);
        const Marked m = mark(scene);
        EXPECT_GT(m.counts.loose(), 10u);
        EXPECT_LT(m.counts.loose(), 60u);
        return m.data.nodes;
    };
    const auto one = flags(1);
    for (int threads : {2, 7}) {
        const auto other = flags(threads);
        ASSERT_EQ(other.size(), one.size());
        EXPECT_EQ(std::memcmp(other.data(), one.data(), one.size() * sizeof(TreeNode)), 0)
            << threads;
    }
    auto before = mark(scene).loose();
    std::reverse(scene.begin(), scene.end());
    auto after = mark(scene).loose();
    const auto by_place = [](const Vec3d& a, const Vec3d& b) { return a.x < b.x; };
    std::sort(before.begin(), before.end(), by_place);
    std::sort(after.begin(), after.end(), by_place);
    EXPECT_EQ(before, after);
}

}  // namespace
}  // namespace slim::test
