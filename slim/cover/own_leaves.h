#pragma once

#include "slim/cover/cover_rules.h"
#include "slim/cover/leaf_maker.h"
#include "slim/model/fitted_surfel.h"
#include "slim/neighbors/point_tree.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>

namespace slim {

/// What gets leaves of its own, and what does not.
struct OwnLeafRules {
    std::span<const std::uint64_t> strays;   ///< ids: never
    std::span<const std::uint64_t> dropped;  ///< ids of strays and of points beside others: no gaps
    bool at_gaps;
};

struct OwnLeavesFound {
    std::deque<CoveringSurfel> leaves;
    std::size_t n_at_gaps = 0;  ///< the first ones
};

/// Leaves of their own for points beside gaps between the others (notes/0021), and, where leaves
/// are fitted again, for those that the blend of all passes by farther off than
/// CoverRules::farthest() (notes/0016): the farthest first, in rounds, as what is added moves its
/// neighbours. Only points that the job owns, that are no strays and that no coarser level dropped;
/// of gaps only such as nobody dropped. block: of `points`; others: as they end, beside those of
/// coarser levels, which the rules know; the same objects as long as this runs.
/// Cost: find_gaps(), and its gaps times the leaves that close some; far_points() of all once; a
/// search of a radius and a fit a leaf, by one thread; a byte a point.
OwnLeavesFound own_leaves(const PointTree& points, const PointBlock& block,
                          const CoverRules& rules, const LeafMaker& maker,
                          const SurfelSource& others, const OwnLeafRules& own, LeafWork& work);

}  // namespace slim
