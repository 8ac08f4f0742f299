#include "slim/tree/tree_builder.h"

#include "slim/base/error.h"
#include "slim/cover/level_cover.h"
#include "slim/tree/ball_index.h"
#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <vector>

#include <malloc.h>

namespace slim::test {
namespace {

/// Surfels of a fit, with more than one page of them.
const std::vector<FittedSurfel>& fitted() {
    static const std::vector<FittedSurfel> surfels = [] {
        const PointBlock block = block_of(sampled("sculpture", 30000));
        CoverRules rules;
        rules.diagonal = box_of(block).diagonal();
        rules.mdl_threshold = 0.002;
        rules.noise_variance = 1e-9;
        rules.least_radius = 1e-12;
        Reporter silent;
        return cover_points(block, rules, silent).surfels;
    }();
    return surfels;
}

FittedSurfel simple(const Vec3d& center, double radius, int level, bool leaf) {
    FittedSurfel f;
    f.surfel = {center, radius, frame_from_normal(Vec3d{0, 0, 1}), {}, 2};
    f.level = static_cast<std::uint8_t>(level);
    f.flags = leaf ? kLeaf : 0;
    return f;
}

SurfelTreeData build(const std::vector<FittedSurfel>& surfels, TreeCounts& counts) {
    ModelHeader header;
    header.degree = 2;
    header.diagonal = 3;
    return build_tree(surfels, header, counts);
}

/// Parents by node; also checks that every node but the root is a child once, after its parent.
std::vector<std::size_t> parents_of(const SurfelTree& tree) {
    std::vector<std::size_t> parent(tree.n_nodes(), tree.n_nodes());
    for (std::size_t i = 0; i < tree.n_nodes(); ++i) {
        const TreeNode& node = tree.node(i);
        if (node.n_children == 0) continue;
        EXPECT_GT(node.first_child, i);
        EXPECT_LE(node.first_child + node.n_children, tree.n_nodes());
        for (std::size_t c = node.first_child; c < node.first_child + node.n_children; ++c) {
            EXPECT_EQ(parent[c], tree.n_nodes()) << "two parents";
            parent[c] = i;
        }
    }
    for (std::size_t i = 1; i < tree.n_nodes(); ++i) EXPECT_LT(parent[i], i);
    return parent;
}

TEST(TreeBuilder, HoldsEverySurfelOnceBelowItsParent) {
    TreeCounts counts;
    const SurfelTreeData data = build(fitted(), counts);
    const SurfelTree tree = data.view();
    ASSERT_GT(tree.n_nodes(), 2 * kSurfelsPerPage);
    EXPECT_EQ(tree.n_nodes() + counts.childless, fitted().size() + 1);
    parents_of(tree);
    std::size_t leaves = 0, expected = 0;
    for (const FittedSurfel& s : fitted()) expected += (s.flags & kLeaf) != 0;
    for (const TreeNode& n : tree.nodes()) leaves += n.is_leaf();
    EXPECT_EQ(leaves, expected);
    EXPECT_EQ(tree.header().n_leaves, expected);
}

TEST(TreeBuilder, KeepsWhatTheFitSaysOfEachSurfel) {
    TreeCounts counts;
    const SurfelTreeData data = build(fitted(), counts);
    const SurfelTree tree = data.view();
    using Key = std::tuple<float, std::uint32_t, int, int, int, float>;
    std::multiset<Key> before, after;
    for (const FittedSurfel& s : fitted())
        if (s.flags & kLeaf)
            before.insert({static_cast<float>(s.fit_error), s.n_points, s.level, s.flags,
                           s.surfel.degree, static_cast<float>(s.surfel.support_radius)});
    for (std::size_t i = 1; i < tree.n_nodes(); ++i) {
        const TreeNode& n = tree.node(i);
        if (n.is_leaf())
            after.insert({n.fit_error, n.n_points, n.level, n.flags, n.degree,
                          static_cast<float>(tree.support_radius(i))});
    }
    EXPECT_EQ(before, after);
    EXPECT_FALSE(tree.node(0).is_leaf());
}

TEST(TreeBuilder, BoundRadiiEncloseAllBelow) {
    TreeCounts counts;
    const SurfelTreeData data = build(fitted(), counts);
    const SurfelTree tree = data.view();
    const std::vector<std::size_t> parent = parents_of(tree);
    for (std::size_t i = 1; i < tree.n_nodes(); ++i)
        for (std::size_t a = i;;) {  // all ancestors, the surfel itself included
            ASSERT_LE(length(tree.center(i) - tree.center(a)) + tree.support_radius(i),
                      static_cast<double>(tree.node(a).bound_radius));
            if (a == 0) break;
            a = parent[a];
        }
    EXPECT_GE(static_cast<double>(tree.node(0).bound_radius), tree.support_radius(0));
}

TEST(TreeBuilder, ChildrenAreOfFinerLevelsAndTheParentIsTheNearest) {
    TreeCounts counts;
    const SurfelTreeData data = build(fitted(), counts);
    const SurfelTree tree = data.view();
    const std::vector<std::size_t> parent = parents_of(tree);
    std::map<int, std::vector<Vec3d>> internals;
    for (const FittedSurfel& s : fitted())
        if (!(s.flags & kLeaf)) internals[s.level].push_back(s.surfel.center);
    for (std::size_t i = 1; i < tree.n_nodes(); i += 7) {
        if (parent[i] == 0) continue;
        const TreeNode& above = tree.node(parent[i]);
        EXPECT_LT(above.level, tree.node(i).level);
        EXPECT_FALSE(above.is_leaf());
        double nearest = INFINITY;
        for (const Vec3d& c : internals[above.level])
            nearest = std::min(nearest, length(c - tree.center(i)));
        EXPECT_NEAR(length(tree.center(parent[i]) - tree.center(i)), nearest, 1e-6);
    }
    for (std::size_t i = 1; i < tree.n_nodes(); ++i)
        EXPECT_NE(tree.node(i).is_leaf(), tree.node(i).n_children > 0);
}

// Cuts draw a small ball for all below it, so nothing below may lie elsewhere.
TEST(TreeBuilder, WhatIsBelowABallLiesAboutIt) {
    TreeCounts counts;
    const SurfelTreeData data = build(fitted(), counts);
    const SurfelTree tree = data.view();
    EXPECT_GT(counts.orphans, 0u);  // that would lie elsewhere
    for (std::size_t i = 1; i < tree.n_nodes(); ++i)
        ASSERT_LT(static_cast<double>(tree.node(i).bound_radius), 3 * tree.support_radius(i)) << i;
}

TEST(TreeBuilder, FamiliesStandNearInSpace) {
    TreeCounts counts;
    const SurfelTreeData data = build(fitted(), counts);
    const SurfelTree tree = data.view();
    // A page of 1024 of some thousand surfels is much smaller than the model: the mean distance of
    // neighbours in the file is a small part of that of random pairs.
    double near = 0, far = 0;
    for (std::size_t i = 1; i + 1 < tree.n_nodes(); ++i) {
        near += length(tree.center(i + 1) - tree.center(i));
        far += length(tree.center(1 + keyed_hash(1, i) % (tree.n_nodes() - 1)) - tree.center(i));
    }
    EXPECT_LT(near, 0.25 * far);
}

TEST(TreeBuilder, GenerationsFollowEachOther) {
    TreeCounts counts;
    const SurfelTreeData data = build(fitted(), counts);
    const SurfelTree tree = data.view();
    const auto parent = parents_of(tree);
    std::vector<int> generation(tree.n_nodes(), 0);
    for (std::size_t i = 1; i < tree.n_nodes(); ++i) {
        generation[i] = generation[parent[i]] + 1;
        EXPECT_GE(generation[i], generation[i - 1]) << i;
        if (i > 1) {
            EXPECT_GE(parent[i], parent[i - 1]) << i;
        }
    }
    EXPECT_GT(generation.back(), 2);
}

TEST(TreeBuilder, OrphansOfAllHangOnTheRootAndChildlessBallsAreLeftOut) {
    const std::vector<FittedSurfel> surfels{
        simple({0, 0, 0}, 1, 1, false),     // one of the leaves of level 2 is in it
        simple({10, 0, 0}, 1, 1, false),    // nobody below
        simple({0.5, 0, 0}, 0.5, 2, true),  // inside
        simple({3, 0, 0}, 0.5, 2, true),    // in no ball of level 1: an orphan
        simple({-4, 0, 0}, 1, 1, true),     // a leaf of the top level hangs on the root
    };
    TreeCounts counts;
    const SurfelTreeData data = build(surfels, counts);
    EXPECT_EQ(counts.orphans, 1u);
    EXPECT_EQ(counts.childless, 1u);
    ASSERT_EQ(data.nodes.size(), 5u);
    const SurfelTree tree = data.view();
    const auto parent = parents_of(tree);
    for (std::size_t i = 1; i < 5; ++i) {
        const bool inside = length(tree.center(i) - Vec3d{0.5, 0, 0}) < 1e-6;
        EXPECT_EQ(parent[i] == 0, !inside);
        if (inside) {
            EXPECT_NEAR(length(tree.center(parent[i])), 0, 1e-6);
        }
    }
    EXPECT_EQ(tree.node(0).n_children, 3u);
}

TEST(TreeBuilder, AnEmptyLevelIsBridged) {
    const std::vector<FittedSurfel> surfels{simple({0, 0, 0}, 1, 1, false),
                                            simple({0.1, 0, 0}, 0.1, 5, true)};
    TreeCounts counts;
    const SurfelTreeData data = build(surfels, counts);
    ASSERT_EQ(data.nodes.size(), 3u);
    EXPECT_EQ(data.nodes[0].n_children, 1u);
    EXPECT_EQ(data.nodes[1].level, 1);
    EXPECT_EQ(data.nodes[1].first_child, 2u);
}

TEST(TreeBuilder, RefusesAFitWithoutLeaves) {
    TreeCounts counts;
    const std::vector<FittedSurfel> none, internal{simple({0, 0, 0}, 1, 1, false)};
    EXPECT_THROW(build(none, counts), DataError);
    EXPECT_THROW(build(internal, counts), DataError);
}

TEST(TreeBuilder, TheOrderOfSurfelsInOneLevelChangesNoLeafOrBound) {
    std::vector<FittedSurfel> turned = fitted();
    std::reverse(turned.begin(), turned.end());
    TreeCounts a, b;
    const SurfelTreeData one = build(fitted(), a), two = build(turned, b);
    ASSERT_EQ(one.nodes.size(), two.nodes.size());
    EXPECT_EQ(one.records, two.records);  // Morton order of centres, none of which coincide
    for (std::size_t i = 0; i < one.nodes.size(); ++i) {
        ASSERT_EQ(one.nodes[i].first_child, two.nodes[i].first_child);
        ASSERT_EQ(one.nodes[i].bound_radius, two.nodes[i].bound_radius);
    }
}

/// Bytes that the program holds on the heap; 0 where another allocator counts (sanitizers).
std::size_t heap_bytes() {
    const struct mallinfo2 info = ::mallinfo2();
    return info.uordblks + info.hblkhd;
}

TEST(TreeBuilder, HoldsAFewBytesASurfelWhilstTheSourceIsRead) {
    constexpr std::size_t n = 200000;
    const std::size_t before = heap_bytes();
    std::size_t n_reads = 0, most[2] = {0, 0};
    const SurfelSource source = [&](const SurfelVisit& visit) {
        ASSERT_LT(n_reads, 2u);
        for (std::uint64_t i = 0; i < n; ++i) {
            visit(simple(random_in_cube(1, i), i < 4000 ? 0.1 : 0.01, i < 4000 ? 1 : 2, i >= 4000));
            if (i % 1000 == 0 || i + 1 == n)
                most[n_reads] = std::max(most[n_reads], heap_bytes() - before);
        }
        ++n_reads;
    };
    ModelHeader header;
    TreeCounts counts;
    const SurfelTreeData data = build_tree(source, n, header, counts);
    EXPECT_EQ(n_reads, 2u);
    EXPECT_EQ(data.header.n_leaves, n - 4000);
    EXPECT_LT(most[0], 45 * n);  // balls
    EXPECT_LT(most[1], 90 * n);  // nodes, records and where each surfel goes
}

TEST(BallIndex, FindsTheLeavesOverAPointLikeBruteForce) {
    TreeCounts counts;
    const SurfelTreeData data = build(fitted(), counts);
    const SurfelTree tree = data.view();
    const BallIndex index(tree);
    EXPECT_EQ(index.n_leaves(), tree.header().n_leaves);
    std::vector<const Surfel*> found;
    for (std::uint64_t q = 0; q < 300; ++q) {
        const Vec3d p =
            tree.center(1 + keyed_hash(2, q) % (tree.n_nodes() - 1)) + random_in_cube(3, q) * 0.1;
        index.supporters(p, found);
        std::multiset<double> a, b;
        for (const Surfel* s : found) a.insert(s->center.x);
        for (std::size_t i = 1; i < tree.n_nodes(); ++i) {
            const double rho = tree.support_radius(i);
            if (tree.node(i).is_leaf() && sq_length(p - tree.center(i)) < rho * rho)
                b.insert(tree.center(i).x);
        }
        ASSERT_EQ(a, b);
    }
    index.supporters({100, 0, 0}, found);
    EXPECT_TRUE(found.empty());
}

}  // namespace
}  // namespace slim::test
