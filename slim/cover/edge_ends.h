#pragma once

#include "slim/cover/blend_refit.h"
#include "slim/cover/needless_leaves.h"
#include "slim/model/fitted_surfel.h"
#include "slim/neighbors/point_tree.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// Gives smooth leaves that stand out past an edge, as the sharp leaves about them know it, a rim
/// there, where others draw all else that the rim cuts off (notes/0024). Blend and n_drawn as of
/// remove_needless, which comes after it; both follow the rims. Returns how many leaves got one.
/// Models without sharp leaves keep theirs. The same for any number of threads.
/// Cost: 61 places of each smooth leaf that meets a sharp one, held against the sharp ones that
/// hold them; a gather for each of those that stand out.
std::size_t end_at_edges(const PointTree& points, const NeedlessRules& rules,
                         std::span<BlendResidual> blend, std::span<std::uint8_t> n_drawn,
                         std::vector<std::vector<FittedSurfel>>& leaves);

}  // namespace slim
