#pragma once

#include "slim/cover/blend_refit.h"
#include "slim/cover/cover_rules.h"
#include "slim/cover/covering_surfel.h"
#include "slim/model/fitted_surfel.h"
#include "slim/neighbors/point_tree.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace slim {

/// What a leaf does to the blend at a point that it covers.
struct LeafShare {
    std::uint32_t point;
    float weight, height;  ///< added to BlendResidual's
    bool is_drawn;         ///< in its core and within its rims
};

LeafShare leaf_share(const Surfel& leaf, const Covered& point);

/// When a leaf is needless.
struct NeedlessRules {
    double noise_variance;  ///< lambda
    double most_worse;      ///< by how much, without a quadratic leaf, the sum over its points of
                            ///< BlendResidual::off() squared may grow; length^2
    double farthest;        ///< no point may lie farther off then, or than it lay before; length
};

/// Sees a leaf and its number among all.
using NumberedVisit = std::function<void(const FittedSurfel&, std::size_t)>;

/// spacing: of the job's points, length.
NeedlessRules needless_rules(const CoverRules& rules, double spacing);

/// Takes smooth leaves away without which every point is still drawn, under enough weight, and the
/// blend is hardly worse: those that it needs least first (notes/0022).
///
/// centers: of the leaves, places in the block, piece after piece; blend, n_drawn: of the block's
/// points, with all leaves in them, those that do not wait too; changed as leaves go, which
/// `removed` sees. The same for any number of threads.
/// Cost: a look at each leaf's centre; a gather, and 16 bytes a point of its ball, for each that
/// its centre does not need (a third).
void remove_needless(const PointTree& points, const NeedlessRules& rules,
                     std::span<const std::uint32_t> centers, std::span<BlendResidual> blend,
                     std::span<std::uint8_t> n_drawn,
                     std::vector<std::vector<FittedSurfel>>& leaves, const NumberedVisit& removed);

}  // namespace slim
