#pragma once

#include "slim/model/surfel.h"
#include "slim/model/surfel_tree.h"

#include <cmath>
#include <cstddef>

namespace slim {

/// Radius of a surfel that stands in, as drawn, over its own.
inline constexpr double kStandInScale = 1 / kHitTrim;

/// The surfel of a node that stands in for what is below (kStandsIn), as it is drawn: in a ball so
/// much larger that renderers, which look for hits in the core (kHitTrim), look in all of its own.
/// Balls of internal surfels cover the points of their level, their cores do not: the far side was
/// seen through gaps between them.
inline Surfel stand_in(Surfel s) {
    constexpr int kDegree[] = {0, 1, 1, 2, 2, 2, 3, 3, 3, 3};
    s.support_radius *= kStandInScale;
    for (std::size_t k = 0; k < s.polynomial.a.size(); ++k)
        s.polynomial.a[k] *= std::pow(kStandInScale, kDegree[k] - 1);
    return s;
}

/// What renderers draw of a node of a cut.
inline Surfel drawn_surfel(const SurfelTree& tree, std::size_t node) {
    const Surfel s = tree.surfel(node);
    return tree.node(node).flags & kStandsIn ? stand_in(s) : s;
}

}  // namespace slim
