#pragma once

#include "slim/model/fitted_surfel.h"
#include "slim/neighbors/point_tree.h"

#include <cstddef>
#include <span>

namespace slim {

/// How far a point stands off the blend of the leaves that cover it: off() = sum G_i h_i / sum G_i,
/// h_i its height above leaf i; to first order the distance of eq. (6), Ohtake 2005,
/// without its sign.
struct BlendResidual {
    float weight = 0;  ///< sum G
    float height = 0;  ///< sum G h, length

    double off() const { return weight > 0 ? height / weight : 0; }
};

/// Fits smooth leaves a second time, to what their blend leaves over (notes/0010; twicing, Tukey
/// 1977): a polynomial of the leaf's own degree to off() over its ball under G, added to its own,
/// less the share of it that chance explains. What neighbours err alike shrinks; what single points
/// err stays. fit_error grows by what a leaf is moved off its own points; sharp leaves stay as they
/// are. residuals: of the block's points; `moved`, of as many or empty, takes what is to be added
/// to their heights. Returns how many leaves moved; the same for any number of threads, and but for
/// the rounding of `moved` for any order of the leaves. Cost: a visit a point and ball that holds
/// it, a fit a leaf; less where leaves that follow each other lie together. With `moved` 8 bytes a
/// point of each of the balls.
std::size_t refit_to_blend(const PointTree& points, std::span<const BlendResidual> residuals,
                           std::span<FittedSurfel* const> leaves, std::span<float> moved = {});

}  // namespace slim
