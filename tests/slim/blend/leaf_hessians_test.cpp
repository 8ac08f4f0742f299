#include "slim/blend/leaf_hessians.h"

#include "slim/base/error.h"
#include "slim/blend/blend.h"
#include "tests/raytrace/support/analytic_models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

namespace slim {
namespace {

/// Leaves of w = c x^3 over the plane, each the quadric that touches it, on a grid.
std::vector<Surfel> leaves_of_cubic(double c, double rho, double step, int n) {
    std::vector<Surfel> leaves;
    for (int i = -n; i <= n; ++i)
        for (int j = -n; j <= n; ++j) {
            const double x = (i + 0.5 * (j & 1)) * step, y = j * step;
            Surfel s{{x, y, c * x * x * x}, rho, frame_from_normal(Vec3d{0, 0, 1}), {}, 2};
            s.polynomial.a[1] = 3 * c * x * x;
            s.polynomial.a[3] = 3 * c * x * rho;
            leaves.push_back(s);
        }
    return leaves;
}

/// The node of the leaf nearest a place.
std::uint32_t nearest(const SurfelTree& tree, const Vec3d& p) {
    std::uint32_t best = 1;
    for (std::uint32_t i = 1; i < tree.n_nodes(); ++i)
        if (length(tree.center(i) - p) < length(tree.center(best) - p)) best = i;
    return best;
}

TEST(LeafHessians, AQuadricTakesItsSlopesFromTheLeavesAround) {
    const double c = 0.02, rho = 0.3;
    const SurfelTreeData data = test::flat_tree(leaves_of_cubic(c, rho, 0.2, 8), 2);
    const SurfelTree tree = data.view();
    LeafHessians hessians(tree);
    hessians.prepare_all();
    const std::uint32_t leaf = nearest(tree, {0.4, 0.2, 0});
    const HeightHessian* h = hessians.of(leaf);
    ASSERT_NE(h, nullptr);
    const double x = tree.center(leaf).x;
    for (const double u : {-0.5, 0.0, 0.5}) {
        const auto at = h->at(u, 0.1);
        // P_uu = rho w_xx; the quadric itself would miss 0.0054 of it
        EXPECT_NEAR(at[0], 6 * c * (x + rho * u) * rho, 6e-4) << u;
        EXPECT_NEAR(at[1], 0, 1e-4);
        EXPECT_NEAR(at[2], 0, 1e-4);
    }
}

/// RMS error of k2 on a torus at a third of rho from its leaves' centres, with the second
/// derivatives of the leaves and with their polynomials' own: of leaves of two radii, each with the
/// mean curvature of its ball.
std::array<double, 2> errors_on_torus() {
    const double big = 1, small = 0.35;
    std::vector<Surfel> leaves;
    const int n_around = 60, n_tube = 24;
    for (int i = 0; i < n_around; ++i)
        for (int j = 0; j < n_tube; ++j)
            leaves.push_back(test::torus_surfel(
                big, small, 2 * std::numbers::pi * (i + 0.5 * (j % 2)) / n_around,
                2 * std::numbers::pi * j / n_tube, (i + j) % 3 == 0 ? 0.2 : 0.14, 2));
    const SurfelTreeData data = test::flat_tree(leaves, 2);
    LeafHessians hessians(data.view());
    hessians.prepare_all();
    std::array<double, 2> sq{};
    double n = 0;
    for (std::uint32_t i = 1; i < data.nodes.size(); ++i) {
        Surfel s = data.view().surfel(i);
        for (const double turn : {0.0, 2.1, 4.2}) {
            const double u = std::cos(turn) / 3, v = std::sin(turn) / 3;
            const Vec3d at = s.center + s.frame.world_from_local({u, v, s.polynomial.value(u, v)}) *
                                            s.support_radius;
            const double out = std::hypot(at.x, at.y) - big;
            const double cosine = out / std::hypot(out, at.z),
                         k2 = cosine / (big + small * cosine);
            for (std::size_t better = 0; better < 2; ++better) {
                s.hessian = better ? hessians.of(i) : nullptr;
                const Surfel* one[] = {&s};
                const auto put = project_along(at, s.frame.normal, one, true);
                sq[better] += std::pow(put->curvature.k2 - k2, 2);
            }
            ++n;
        }
    }
    return {std::sqrt(sq[0] / n), std::sqrt(sq[1] / n)};
}

TEST(LeafHessians, OfATorusTheyErrAQuarterAsMuchAsItsQuadrics) {
    const auto [own, better] = errors_on_torus();
    EXPECT_GT(own, 0.05);
    EXPECT_LT(better, own / 4);
}

TEST(LeafHessians, ALeafAtARimDoesNotFollowItsOwnNoise) {
    auto leaves = leaves_of_cubic(0, 0.3, 0.2, 8);
    std::erase_if(leaves, [](const Surfel& s) { return s.center.x > 0.05; });
    std::size_t own = 0;
    for (std::size_t i = 0; i < leaves.size(); ++i)
        if (leaves[i].center.x > leaves[own].center.x && std::abs(leaves[i].center.y) < 0.3)
            own = i;
    leaves[own].polynomial.a[3] = 0.05;  // alone in being bent
    const SurfelTreeData data = test::flat_tree(leaves, 2);
    LeafHessians hessians(data.view());
    hessians.prepare_all();
    const HeightHessian* h = hessians.of(static_cast<std::uint32_t>(own + 1));
    ASSERT_NE(h, nullptr);
    EXPECT_NEAR(h->at(0.5, 0.0)[0], 0.1, 0.02);  // not bent more and more towards the open side
}

TEST(LeafHessians, WhatOthersSayAtRandomIsNotFollowed) {
    auto leaves = leaves_of_cubic(0, 0.3, 0.2, 8);
    for (std::size_t i = 0; i < leaves.size(); ++i)
        leaves[i].polynomial.a[3] = 0.05 * std::sin(static_cast<double>(97 * i));
    const SurfelTreeData data = test::flat_tree(leaves, 2);
    LeafHessians hessians(data.view());
    hessians.prepare_all();
    std::size_t turned = 0, n = 0;
    for (std::uint32_t i = 1; i < data.nodes.size(); ++i, ++n) {
        const auto right = hessians.of(i)->at(0.5, 0.0), left = hessians.of(i)->at(-0.5, 0.0);
        if (std::abs(right[0] - left[0]) > 0.02) ++turned;
    }
    EXPECT_LT(turned, n / 4);
}

TEST(LeafHessians, NeitherAnotherSheetNorLooseOnesHaveASay) {
    auto leaves = leaves_of_cubic(0.02, 0.3, 0.2, 8);
    const std::size_t n = leaves.size();
    for (std::size_t i = 0; i < n; ++i) {
        Surfel above = leaves[i];  // twice kBelongs off, as steep the other way
        above.center.z += 0.18, above.polynomial.a[3] = -0.3;
        leaves.push_back(above);
        Surfel back = leaves[i];
        back.frame = frame_from_normal(Vec3d{0, 0, -1}), back.polynomial = {};
        back.polynomial.a[3] = 0.4;
        leaves.push_back(back);
        Surfel loose = leaves[i];
        loose.polynomial.a[3] = 0.5;
        leaves.push_back(loose);
    }
    SurfelTreeData data = test::flat_tree(leaves, 2), alone = test::flat_tree({leaves.begin(),
        leaves.begin() + static_cast<std::ptrdiff_t>(n)}, 2);
    for (std::size_t i = n; i < leaves.size(); i += 3) data.nodes[i + 3].flags |= kLoose;
    LeafHessians among(data.view()), without(alone.view());
    among.prepare_all(), without.prepare_all();
    for (std::uint32_t i = 1; i <= n; ++i)
        for (std::size_t k = 0; k < 3; ++k)
            for (std::size_t j = 0; j < 6; ++j)
                ASSERT_NEAR(among.of(i)->c[k][j], without.of(i)->c[k][j], 1e-6);
    EXPECT_EQ(among.of(static_cast<std::uint32_t>(n + 3)), nullptr);
}

TEST(LeafHessians, CubicModelsHaveNone) {
    const SurfelTreeData data = test::torus_model(1, 0.35, 40, 16, 3);
    LeafHessians hessians(data.view());
    hessians.prepare_all();
    EXPECT_EQ(hessians.of(5), nullptr);
}

TEST(LeafHessians, InternalSurfelsPlanesAndSharpOnesHaveNone) {
    auto leaves = leaves_of_cubic(0.02, 0.3, 0.2, 2);
    leaves[3].degree = 1;
    SurfelTreeData data = test::flat_tree(leaves, 2);
    data.nodes[7].flags |= kSharp;
    LeafHessians hessians(data.view());
    hessians.prepare_all();
    EXPECT_EQ(hessians.of(0), nullptr);
    EXPECT_EQ(hessians.of(4), nullptr);
    EXPECT_EQ(hessians.of(7), nullptr);
    EXPECT_NE(hessians.of(5), nullptr);
}

TEST(LeafHessians, AreTheSameWhateverIsAskedForFirst) {
    const SurfelTreeData data = test::torus_model(1, 0.35, 40, 16, 2);
    LeafHessians at_once(data.view()), by_and_by(data.view());
    at_once.prepare_all();
    const auto n = static_cast<std::uint32_t>(data.nodes.size());
    for (std::uint32_t i = n - 1; i > 0; i -= std::min(i, 7u)) {
        const std::uint32_t some[] = {i, n - i, i};
        by_and_by.prepare(some);
        const HeightHessian *a = at_once.of(i), *b = by_and_by.of(i);
        ASSERT_EQ(a == nullptr, b == nullptr);
        if (a) ASSERT_EQ(a->c, b->c);
    }
}

TEST(LeafHessians, TellWhatTheyLookAtBeforeItsSurfelsAre) {
    const SurfelTreeData data = test::two_level_sphere(1, 40, 600);
    const SurfelTree tree = data.view();
    std::uint32_t leaf = 0;
    while (!tree.node(leaf).is_leaf()) ++leaf;
    std::vector<std::uint32_t> met;
    LeafHessians hessians(tree);
    const std::uint32_t one[] = {leaf};
    hessians.prepare(one, [&](auto nodes) { met.assign(nodes.begin(), nodes.end()); });
    for (std::uint32_t i = 0; i < tree.n_nodes(); ++i) {
        if (!tree.node(i).is_leaf()) continue;
        const bool near =
            length(tree.center(i) - tree.center(leaf)) < 1.9 * tree.support_radius(leaf);
        EXPECT_TRUE(!near || std::binary_search(met.begin(), met.end(), i)) << i;
    }
    EXPECT_LT(met.size(), tree.n_nodes() / 2);
}

TEST(LeafHessians, ATreeWithACycleIsAnError) {
    SurfelTreeData data = test::two_level_sphere(1, 40, 600);
    for (TreeNode& node : data.nodes)
        if (!node.is_leaf() && node.first_child > 1) node.first_child = 1;
    LeafHessians hessians(data.view());
    EXPECT_THROW(hessians.prepare_all(), FormatError);
}

}  // namespace
}  // namespace slim
