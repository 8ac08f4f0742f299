#pragma once

#include "slim/cover/blend_refit.h"
#include "slim/cover/cover_rules.h"
#include "slim/cover/covering_surfel.h"
#include "slim/model/fitted_surfel.h"
#include "slim/model/rim.h"
#include "slim/neighbors/point_tree.h"

#include <algorithm>
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

/// The shares of one leaf, whose rims are unpacked once.
class LeafShares {
public:
    explicit LeafShares(const Surfel& leaf)
        : first_(unpack_rim(leaf.rims.first)), second_(unpack_rim(leaf.rims.second)),
          rho_(static_cast<float>(leaf.support_radius)), is_whole_(!leaf.rims.any()) {}

    LeafShare of(const Covered& p) const {
        const double share =
            is_whole_ ? 1 : std::min(rim_share(first_, p.u, p.v), rim_share(second_, p.u, p.v));
        const float weight = p.weight * static_cast<float>(share);
        return {p.point, weight, weight * p.off * rho_, p.in_core && share > 0};
    }

private:
    Rim first_, second_;
    float rho_;
    bool is_whole_;
};

/// When a leaf is needless.
struct NeedlessRules {
    double noise_variance;  ///< lambda
    double most_worse;      ///< by how much, without a quadratic leaf, the sum over its points of
                            ///< BlendResidual::off() squared may grow; length^2
    double farthest;        ///< no point may lie farther off then, or than it lay before; length
    /// Whose centres are decided on here (CoverRules::owns); empty: all.
    std::function<bool(const Vec3d&)> owns = {};
};

/// Whether leaves may be needless: not where points are noisy, as the more leaves a point has the
/// less of its noise is left in curvature. spacing: of the job's points, length.
bool may_be_needless(const CoverRules& rules, double spacing);

/// Sees a leaf and its number among all.
using NumberedVisit = std::function<void(const FittedSurfel&, std::size_t)>;

/// spacing: as above.
NeedlessRules needless_rules(const CoverRules& rules, double spacing);

/// Takes smooth leaves away without which every point is still drawn, under enough weight, and the
/// blend is hardly worse: those that it needs least first (notes/0023).
///
/// centers: of the leaves, places in the block, piece after piece; blend: of the block's points, with
/// all leaves in it, those that do not wait too; n_drawn: how many draw each, without those of other
/// slices, which may take them away: what is drawn here relies on none. Both are changed as leaves
/// go, which `removed` sees. The same for any number of threads.
/// Cost: a look at each leaf's centre; a gather for each that its centre does not need (a third); 16
/// bytes a point of its ball and 61 places asked of its neighbours for each that may go.
void remove_needless(const PointTree& points, const NeedlessRules& rules,
                     std::span<const std::uint32_t> centers, std::span<BlendResidual> blend,
                     std::span<std::uint8_t> n_drawn,
                     std::vector<std::vector<FittedSurfel>>& leaves, const NumberedVisit& removed);

}  // namespace slim
