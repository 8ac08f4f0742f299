#pragma once

#include "slim/base/parallel_batches.h"
#include "slim/edges/corners.h"
#include "slim/tree/ball_index.h"

#include <cstdint>
#include <vector>

namespace slim {

/// Where edges will likely be followed from, if each leaf's edge that none has passed yet starts
/// one, in order: the first of those that lead to each other over the leaves about their starts.
/// Rising LeafEdge::number(). A guess: it decides what is done at the same time, never what comes
/// of it. cost  one blend a leaf's edge, in parallel: a tenth of what following takes; 40 bytes a
/// leaf
std::vector<std::uint32_t> likely_starts(const BallIndex& leaves, const Corners& corners,
                                         const EachBatch& each_batch);

}  // namespace slim
