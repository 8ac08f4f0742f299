#pragma once

#include "slim/cover/cover_rules.h"
#include "slim/cover/leaf_maker.h"
#include "slim/cover/second_fit.h"
#include "slim/neighbors/point_tree.h"

#include <cstdint>
#include <deque>
#include <span>

namespace slim {

/// Leaves of their own for points that the blend of all others passes by farther off than
/// CoverRules::farthest() (notes/0016): the farthest first, in rounds, as what is added moves its
/// neighbours. Only points that the job owns, that are no strays and that no coarser level dropped.
/// block: of `points`; others: as they end, beside those of coarser levels, which the rules know;
/// strays: ids Cost: far_points() of all points once; a search of a radius and a fit a leaf, by one
/// thread; a byte a point.
std::deque<CoveringSurfel> own_leaves(const PointTree& points, const PointBlock& block,
                                      const CoverRules& rules, const LeafMaker& maker,
                                      const SecondFit& others,
                                      std::span<const std::uint64_t> strays, LeafWork& work);

}  // namespace slim
