#pragma once

#include "slim/cover/blend_refit.h"
#include "slim/cover/surfel_fit.h"
#include "slim/model/fitted_surfel.h"
#include "slim/neighbors/point_tree.h"

#include <cstddef>
#include <vector>

namespace slim {

/// Leaves that wait until all are known to be fitted a second time, and what their blend leaves
/// over (blend_refit.h).
class SecondFit {
public:
    /// Of so many points.
    explicit SecondFit(std::size_t n_points) : blend_(n_points) {}

    /// Adds a leaf to what the blend leaves over at its points:
    /// those that are not fitted again too.
    void blend(const CoveringSurfel& leaf);
    void wait(const FittedSurfel& leaf);
    /// Fits all that wait; returns how many moved.
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
    std::vector<BlendResidual> blend_;
    std::vector<std::vector<FittedSurfel>> waiting_;
};

}  // namespace slim
