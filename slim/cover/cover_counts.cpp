#include "slim/cover/cover_counts.h"

#include "slim/cover/two_layers.h"
#include "slim/model/surfel_tree.h"

#include <algorithm>

namespace slim {

void CoverCounts::add_leaf(const CoveringSurfel& leaf) {
    ++leaves;
    saturated += (leaf.fitted.flags & kSaturated) != 0;
    forced += (leaf.fitted.flags & kForced) != 0;
    normals_disagree += leaf.normals_disagree;
    two_layers += lies_between_layers(leaf);
    sharp_edges += leaf.fitted.surfel.n_sheets() == 2;
    sharp_corners += leaf.fitted.surfel.n_sheets() > 2;
    ++fallbacks[static_cast<std::size_t>(leaf.fallback)];
    ++degrees[static_cast<std::size_t>(leaf.fitted.surfel.degree)];
}

LeafCount count_of(const CoveringSurfel& leaf) {
    return {leaf.fallback, leaf.normals_disagree, lies_between_layers(leaf)};
}

void CoverCounts::take_back(const FittedSurfel& leaf, const LeafCount& count) {
    ++needless, --leaves;
    saturated -= (leaf.flags & kSaturated) != 0;
    forced -= (leaf.flags & kForced) != 0;
    contrary -= (leaf.flags & kLimited) != 0;
    normals_disagree -= count.normals_disagree, two_layers -= count.two_layers;
    --fallbacks[static_cast<std::size_t>(count.fallback)];
    --degrees[static_cast<std::size_t>(leaf.surfel.degree)];
}

CoverCounts& CoverCounts::operator+=(const CoverCounts& b) {
    leaves += b.leaves, internals += b.internals, levels = std::max(levels, b.levels);
    saturated += b.saturated, forced += b.forced, contrary += b.contrary;
    normals_disagree += b.normals_disagree, two_layers += b.two_layers;
    unexplained += b.unexplained, beside += b.beside, isolated += b.isolated;
    sharp_edges += b.sharp_edges, sharp_corners += b.sharp_corners, sharp_rungs += b.sharp_rungs;
    recentred += b.recentred, refitted += b.refitted, own += b.own;
    gaps += b.gaps, needless += b.needless;
    evaluated += b.evaluated, discarded += b.discarded, rungs += b.rungs;
    refinements += b.refinements, point_visits += b.point_visits;
    for (std::size_t i = 0; i < fallbacks.size(); ++i) fallbacks[i] += b.fallbacks[i];
    for (std::size_t i = 0; i < degrees.size(); ++i) degrees[i] += b.degrees[i];
    return *this;
}

}  // namespace slim
