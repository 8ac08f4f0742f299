#pragma once

#include "slim/cover/cover_rules.h"
#include "slim/cover/leaf_maker.h"
#include "slim/model/point_block.h"
#include "slim/neighbors/point_tree.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace slim {

/// What has become of the points of a cover so far: what lies over each, and what an earlier search
/// found of it. Threads may read; who writes is alone. Holds references to all it is given.
class CoverStates {
public:
    /// Points that the rules name as dropped are closed.
    CoverStates(const PointBlock& points, const CoverRules& rules);

    /// Whether a point still wants a leaf: it lies in no core, or under too little weight.
    bool is_open(std::uint32_t p) const {
        const PointState& s = states_[p];
        if (s.flags & kClosed) return false;
        return !((s.flags & kCore) && s.weight >= rules_.coverage());
    }
    std::size_t count_open() const;
    /// Whether any is open. Cost: up to the first one that is, of each part.
    bool has_open() const;
    /// Bits of those that are open, of the bucket of a tree whose first point is its first-th.
    std::uint64_t open_of_bucket(const PointTree& tree, std::size_t first) const {
        std::uint64_t bits = 0;
        const std::size_t n = std::min(PointTree::kBucket, tree.size() - first);
        for (std::size_t k = 0; k < n; ++k)
            bits |= std::uint64_t{is_open(tree.source(first + k))} << k;
        return bits;
    }
    /// Open, and under no internal surfel of that level.
    bool may_lead(std::uint32_t p, int level) const {
        return is_open(p) && states_[p].stamp != level;
    }
    /// Sum of G over the leaves so far.
    float weight(std::uint32_t p) const { return states_[p].weight; }
    /// Whether a leaf that is not doubtful lies near.
    bool is_beside(std::uint32_t p) const { return (states_[p].flags & kBeside) != 0; }

    /// What remember() knows of c.point; false if it was not searched.
    bool recall(LeafCandidate& c) const;
    /// Takes what a search found of c.point.
    void remember(const LeafCandidate& c);

    void close(std::uint32_t p) { states_[p].flags |= kClosed; }
    /// Says that an internal surfel of that level covers a point.
    void stamp(std::uint32_t p, int level) { states_[p].stamp = static_cast<std::uint8_t>(level); }
    /// Adds a leaf at the points that it covers. `is_steady`: it is not doubtful, so that doubtful
    /// ones beside it give way.
    void mark(const CoveringSurfel& leaf, bool is_steady);

    /// Has the state of a point that is looked at soon fetched: points by priority lie anywhere in
    /// memory.
    void prefetch(std::uint32_t p) const { __builtin_prefetch(&states_[p]); }

private:
    enum Flag : std::uint16_t {
        kCore = 1,
        kClosed = 2,
        kForced = 4,
        kSaturatedTop = 8,
        kLimited = 16,
        kThin = 32,
        kBeside = 64,
        kWidened = 128
    };
    /// Side by side, as points by priority lie anywhere in memory.
    struct PointState {
        float weight = 0;
        std::uint16_t flags = 0;
        std::uint8_t stamp = 0;
        std::uint8_t degree : 3 = 0;  // that goes with the radius found by an earlier search
        std::uint8_t further_sheets : 5 = 0;  // likewise, beside the first
    };

    float times(const FittedSurfel& leaf) const;

    const PointBlock& block_;
    const CoverRules& rules_;
    std::vector<PointState> states_;
    std::vector<float> radius_;  // found by an earlier search, 0: not searched
    std::vector<float> finest_;  // the smallest ball that search admitted
};

}  // namespace slim
