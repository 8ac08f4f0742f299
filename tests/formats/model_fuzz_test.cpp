#include "formats/model_check.h"
#include "slim/base/hash.h"
#include "slim/model/surfel_encoder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

namespace slim::test {
namespace {

/// A sound tree of random shape: parents before children, bounds that hold all below. Every second
/// one has surfels of mixed degrees.
SurfelTreeData random_tree(std::uint64_t seed, std::size_t n) {
    const auto degree_of = [&](std::size_t i) {
        return seed % 2 == 0 ? 2 : static_cast<int>(i % 3);
    };
    SurfelTreeData tree;
    tree.header.degree = 2;
    tree.header.diagonal = 10;
    tree.header.bounds = {{0, 0, 0}, {1, 1, 1}};
    std::vector<Surfel> surfels;
    for (std::size_t i = 0; i < n; ++i) {
        const auto random = [&](std::uint64_t k) {
            return unit_interval(keyed_hash(seed, 4 * i + k));
        };
        surfels.push_back({{random(0), random(1), random(2)},
                           0.1 + random(3),
                           frame_from_normal(round_normal(Vec3d{0, 0, 1})),
                           {},
                           degree_of(i)});
    }
    encode_surfels(surfels, tree);
    tree.nodes.resize(n);
    for (std::size_t i = 0, next = 1; i < n; ++i) {
        const std::size_t wanted = 1 + keyed_hash(seed + 1, i) % 4;
        const std::size_t count =
            next <= i + 1 && next < n ? std::min(wanted, n - next) : std::min(wanted - 1, n - next);
        if (count > 0) {
            tree.nodes[i].first_child = static_cast<std::uint32_t>(next);
            tree.nodes[i].n_children = static_cast<std::uint32_t>(count);
        } else {
            tree.nodes[i].flags = kLeaf;
            ++tree.header.n_leaves;
        }
        next += count;
        tree.nodes[i].bound_radius = 100 * static_cast<float>(n - i);
        tree.nodes[i].degree = static_cast<unsigned>(degree_of(i)) & 3u;
    }
    return tree;
}

/// Walks the tree as a reader does; the number of nodes seen, which no sound tree makes larger than
/// n.
std::size_t walk(const SurfelTree& tree) {
    std::vector<std::size_t> stack{0};
    std::size_t seen = 0;
    while (!stack.empty() && seen <= tree.n_nodes()) {
        const TreeNode& node = tree.node(stack.back());
        stack.pop_back();
        ++seen;
        for (std::uint32_t c = 0; c < node.n_children; ++c) stack.push_back(node.first_child + c);
    }
    return seen;
}

/// Overwrites four random bytes of the nodes or the records, aligned, as a wrong writer would.
void damage(SurfelTreeData& tree, std::uint64_t key) {
    const bool nodes = keyed_hash(key, 1) % 2 == 0;
    const std::size_t words =
        nodes ? tree.nodes.size() * sizeof(TreeNode) / 4 : tree.records.size();
    // Small numbers are counts and links that may pass, others anything at all.
    const std::uint64_t any = keyed_hash(key, 2);
    const auto word = static_cast<std::uint32_t>(any % 3 == 0 ? any >> 32 : (any >> 32) % 64);
    auto* bytes = nodes ? reinterpret_cast<unsigned char*>(tree.nodes.data())
                        : reinterpret_cast<unsigned char*>(tree.records.data());
    std::memcpy(bytes + 4 * (keyed_hash(key, 3) % words), &word, 4);
}

TEST(ModelCheck, Row44DamagedTreesAreRefusedWithTheirPlaceOrAreStillTrees) {
    // The checksums are not at work here: this is what a wrong writer could produce.
    std::size_t refused = 0;
    constexpr std::uint64_t runs = 20000;
    for (std::uint64_t run = 0; run < runs; ++run) {
        SurfelTreeData tree = random_tree(run % 10, 20 + run % 10);
        if (run < 10) {
            ASSERT_EQ(check_model(tree.view()).reason, "") << "of an undamaged tree " << run;
        }
        damage(tree, run);
        const ModelFault fault = check_model(tree.view());
        if (!fault.chunk.empty()) {
            ++refused;
            ASSERT_FALSE(fault.reason.empty());
            ASSERT_LT(fault.entry, tree.nodes.size());
            continue;
        }
        // What passes is a tree: every node once, finite, balls within bounds.
        ASSERT_EQ(walk(tree.view()), tree.nodes.size()) << run;
        for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
            ASSERT_TRUE(std::isfinite(tree.view().surfel(i).support_radius));
            ASSERT_GE(static_cast<double>(tree.nodes[i].bound_radius),
                      tree.view().support_radius(i));
        }
    }
    EXPECT_GT(refused, runs / 4);
    EXPECT_LT(refused, runs);
}

}  // namespace
}  // namespace slim::test
