#pragma once

#include "slim/base/joined_sets.h"
#include "slim/base/parallel.h"
#include "slim/model/surfel_tree.h"
#include "slim/neighbors/box_tree.h"
#include "slim/tree/leaf_agreement.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// The leaves of a model and which of them hang together: pieces of leaves that agree where they
/// overlap (leaf_agreement.h), directly or by others. Leaves are numbered from the largest to the
/// smallest octave of radii, along a Morton curve in each. The same for any number of threads.
/// Keeps a reference to the tree's arrays. Cost: O(pairs of overlapping leaves), in parallel; 28
/// bytes a leaf.
class LeafPieces {
public:
    explicit LeafPieces(const SurfelTree& tree);

    std::size_t size() const { return node_.size(); }
    std::uint32_t node(std::size_t leaf) const { return node_[leaf]; }
    double support_radius(std::size_t leaf) const { return tree_.support_radius(node_[leaf]); }

    /// Number of the piece that a leaf is of: that of its first leaf.
    std::uint32_t piece(std::uint32_t leaf) const { return pieces_.find(leaf); }
    void join(std::uint32_t a, std::uint32_t b) { pieces_.join(a, b); }

    /// Two leaves whose balls overlap, and how they stand to each other.
    struct Link {
        std::uint32_t leaf, other;
        Meeting meeting;
    };

    /// Calls take(link) for all that `leaves` have with others and that are not apart, in a fixed
    /// order; found in parallel, some at a time.
    template <class Take>
    void for_links(std::span<const std::uint32_t> leaves, Take&& take) const {
        in_rounds(
            leaves.size(),
            [&](std::size_t i, std::vector<Link>& links) { add_links(leaves[i], links); }, take);
    }

private:
    /// For the search: relative to the middle of all. A pair that touches by less than a float's
    /// rounding is none.
    struct Ball {
        Vec3f center;
        float radius;
    };
    static constexpr std::size_t kGrain = 256;                   // leaves a thread takes at once
    // leaves whose links are held at once
    static constexpr std::size_t kRound = std::size_t{1} << 14;

    /// find(i, links) for all of [0, n) in parallel, then take(link) for what was found.
    template <class Find, class Take>
    static void in_rounds(std::size_t n, Find&& find, Take&& take) {
        std::vector<std::vector<Link>> blocks(std::min(n, kRound) / kGrain + 1);
        for (std::size_t first = 0; first < n; first += kRound) {
            const std::size_t count = std::min(kRound, n - first);
            parallel_blocks(count, kGrain, [&](std::size_t begin, std::size_t end) {
                std::vector<Link>& links = blocks[begin / kGrain];
                for (std::size_t i = begin; i < end; ++i) find(first + i, links);
            });
            for (std::vector<Link>& links : blocks) {
                for (const Link& link : links) take(link);
                links.clear();
            }
        }
    }

    /// Which of two leaves is the one whose samples are looked at.
    bool is_smaller(std::uint32_t leaf, std::uint32_t other) const {
        const double r = support_radius(leaf), other_r = support_radius(other);
        return r < other_r || (r == other_r && leaf > other);
    }

    /// Calls body(other) for every other leaf whose ball overlaps that of `leaf`, in a fixed order.
    template <class Body>
    void for_overlapping(std::uint32_t leaf, Body&& body) const {
        const Ball ball = balls_[leaf];
        const Vec3d center = to_double(ball.center);
        boxes_.for_buckets_in_ball(center, double{ball.radius}, [&](std::size_t begin,
                                                                    std::size_t end) {
            for (std::size_t other = begin; other < end; ++other) {
                const float reach = ball.radius + balls_[other].radius;
                const Vec3f apart = balls_[other].center - ball.center;
                if (dot(apart, apart) < reach * reach && other != leaf)
                    body(static_cast<std::uint32_t>(other));
            }
        });
    }

    void order_leaves();
    void join_what_agrees();
    void add_links(std::uint32_t leaf, std::vector<Link>& links) const;

    SurfelTree tree_;
    std::vector<std::uint32_t> node_;
    std::vector<Ball> balls_;
    JoinedSets pieces_;
    BoxTree boxes_;  // of the balls
};

}  // namespace slim
