#pragma once

#include "slim/base/bbox.h"
#include "slim/model/surfel.h"
#include "slim/model/surfel_tree.h"

#include <cstdint>
#include <vector>

namespace slim {

/// The leaves of a model, decoded, under an implicit tree of boxes: which of them hold a point?
/// For measuring and smoothing, which ask at millions of points. 250 bytes a leaf.
class BallIndex {
public:
    explicit BallIndex(const SurfelTree& tree);

    std::size_t n_leaves() const { return leaves_.size(); }

    /// Writes the leaves with |p - c| < rho to `out`, in the index's order (deterministic).
    void supporters(const Vec3d& p, std::vector<const Surfel*>& out) const;

private:
    static constexpr std::size_t kFanout = 4;
    std::vector<Surfel> leaves_;            // along a Morton curve
    std::vector<std::vector<Bbox>> levels_; // 0: one box a leaf
};

}  // namespace slim
