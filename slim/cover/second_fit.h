#pragma once

#include "slim/cover/blend_refit.h"
#include "slim/cover/cover_counts.h"
#include "slim/cover/needless_leaves.h"
#include "slim/cover/surfel_fit.h"
#include "slim/model/fitted_surfel.h"
#include "slim/neighbors/point_tree.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace slim {

using CountedVisit = std::function<void(const FittedSurfel&, const LeafCount&)>;

/// Leaves that wait until all are known to be fitted a second time, and what their blend leaves
/// over (blend_refit.h).
class SecondFit {
public:
    /// Of so many points. removes: whether remove() is to be called, which asks for more of them.
    SecondFit(std::size_t n_points, bool removes)
        : removes_(removes), blend_(n_points), n_drawn_(removes ? n_points : 0) {}

    bool removes() const { return removes_; }

    /// Adds a leaf to what the blend leaves over at its points: those that are not fitted again too.
    /// stays: no other slice may find it needless.
    void blend(const CoveringSurfel& leaf, bool stays);
    /// center: its place in the block.
    void wait(const CoveringSurfel& leaf, std::uint32_t center);
    /// Takes needless leaves away from those that wait (remove_needless) and hands them over.
    void remove(const PointTree& points, const NeedlessRules& rules, const CountedVisit& removed);
    /// Fits all that wait, twice; returns how many moved at first.
    std::size_t run(const PointTree& points);
    /// Those that wait, in their order.
    template <class Visit>
    void for_each(const Visit& visit) const {
        for (const std::vector<FittedSurfel>& leaves : waiting_)
            for (const FittedSurfel& leaf : leaves) visit(leaf);
    }
    /// The same, whose memory is given back piece by piece: none waits after it.
    template <class Visit>
    void hand_over(const Visit& visit) {
        for (std::vector<FittedSurfel>& leaves : waiting_) {
            for (const FittedSurfel& leaf : leaves) visit(leaf);
            std::vector<FittedSurfel>().swap(leaves);
        }
        waiting_.clear();
    }

private:
    bool removes_;  // the three after the next are for that alone
    std::vector<BlendResidual> blend_;
    std::vector<std::uint8_t> n_drawn_;  // leaves that draw a point and stay, 255 at most
    std::vector<std::uint32_t> centers_;  // of those that wait
    std::vector<LeafCount> counted_;      // likewise
    std::vector<std::vector<FittedSurfel>> waiting_;
};

}  // namespace slim
