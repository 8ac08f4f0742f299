#pragma once

#include "slim/model/surfel.h"
#include "slim/model/surfel_tree.h"

#include <cstddef>

namespace slim {

/// Radius of a surfel that stands in for what is below (kStandsIn), as drawn, over its own; and of
/// an internal surfel that does not agree with leaves all over its ball, which a cut takes where it
/// is small. Balls of internal surfels cover the points of their level, their cores (kHitTrim), in
/// which renderers look for hits, do not: the far side was seen through gaps between them.
inline constexpr double kStandInScale = 1 / kHitTrim, kSmallScale = 1.25;

/// Radius of a node's surfel, as drawn, over its own.
inline double drawn_scale(const TreeNode& node) {
    return node.is_leaf() ? 1 : node.flags & kStandsIn ? kStandInScale : kSmallScale;
}

/// The same surface in a ball so many times as large.
inline Surfel in_larger_ball(Surfel s, double scale) {
    constexpr std::size_t kDegree[] = {0, 1, 1, 2, 2, 2, 3, 3, 3, 3};
    const double factor[] = {1 / scale, 1, scale, scale * scale};
    s.support_radius *= scale;
    for (std::size_t k = 0; k < s.polynomial.a.size(); ++k)
        s.polynomial.a[k] *= factor[kDegree[k]];
    return s;
}

/// What renderers draw of a node of a cut.
inline Surfel drawn_surfel(const SurfelTree& tree, std::size_t node) {
    const double scale = drawn_scale(tree.node(node));
    const Surfel s = tree.surfel(node);
    return scale == 1 ? s : in_larger_ball(s, scale);
}

}  // namespace slim
