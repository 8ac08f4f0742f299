#pragma once

#include "slim/base/parallel_batches.h"
#include "slim/model/sharp_edge.h"
#include "slim/model/surfel_tree.h"

#include <vector>

namespace slim {

/// The sharp edges of a model, where the sheets of its surfels meet, as polylines
/// (slim/edges/notes/0001). Each starts in a leaf that none has passed yet and is followed both
/// ways by steps of a tenth of the leaves' radius, put back on the blended edge (edge_blend.h), to
/// the corner where another sheet cuts it, to where no leaf's core holds it, or round to its start.
/// Edges that meet at a corner share its point.
///
/// loose       with the leaves that are drawn with --loose only
/// each_batch  told how far it is, of twice the leaves; may throw to stop
/// returns     none for models without sharp leaves; in a fixed order, the same for any number of
/// threads cost        O(sharp leaves): about 0.1 ms each, several edges at once (notes/0002); 500
/// bytes a sharp leaf
std::vector<SharpEdge> trace_sharp_edges(const SurfelTree& tree, bool loose,
                                         const EachBatch& each_batch = {});

}  // namespace slim
