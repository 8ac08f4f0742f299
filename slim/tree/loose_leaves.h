#pragma once

#include "slim/model/surfel_tree.h"

#include <cstdint>

namespace slim {

/// What the search for loose leaves found.
struct LooseCounts {
    std::uint64_t pieces = 0;  ///< sets of leaves that hang together (leaf_pieces.h)
    std::uint64_t beside = 0;  ///< loose leaves beside a larger piece
    std::uint64_t in_noise = 0;  ///< loose leaves of pieces that cannot be told from noise
    std::uint64_t astray = 0;  ///< loose leaves of sparse points away from all else

    std::uint64_t loose() const { return beside + in_noise + astray; }
};

/// Marks the leaves (kLoose) that are no part of a surface, as a mesh is rid of its small
/// components: leaves of points that a scanner put beside a rim, of strays, of scans that disagree.
/// They stay in the model, so that their points still have a support; pictures leave them out. An
/// internal node is loose if all below it are.
///
/// Pieces are sets of leaves that agree where they overlap. A piece of few, sparse points is loose
/// - beside a piece of ten times its area, if it has less than half of the points to the area that
///   the leaves there have: fewer points than 40 over that share;
/// - beside such a piece, or with all that touches it, if its leaves are smaller than 9 deviations
///   of the noise and have fewer than 100 points and 2e-4 of the model's area in all;
/// - anywhere, with all that touches it, with less than an eighth of the model's mean points to the
///   area: fewer than 3 over the share.
/// No rule touches a model whose leaves would all be loose, nor a piece of a tenth of its
/// area. The numbers are measured (notes/0002, 0006).
///
/// cost  O(pairs of overlapping leaves): 5 us a leaf, shared out; 44 bytes a leaf beside the model
LooseCounts mark_loose(SurfelTreeData& tree);

}  // namespace slim
