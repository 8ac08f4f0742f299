#pragma once

#include "slim/model/fitted_surfel.h"
#include "slim/model/surfel_tree.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace slim {

/// What linking the levels met.
struct TreeCounts {
    /// surfels that no ball of the level above holds: hung on a coarser one or the root
    std::uint64_t orphans = 0;
    std::uint64_t childless = 0;  ///< internal surfels without a child: left out
};

/// What a tree takes at its peak for one surfel of a source: measured 80 of quadrics (notes/0003).
inline constexpr std::uint64_t kTreeBytesPerSurfel = 100;

/// Links surfels to a ball tree (Ohtake 2005 sec. 2): the parent of a surfel of level k + 1 is the
/// internal surfel of level k whose centre is nearest (balls of a level are equal, so this is the
/// smallest |c' - c| / rho) if its ball holds the surfel, else one of a coarser level
/// (ball_links.h), the root encloses all.
/// Departs from the paper: one parent a node instead of every ball that holds the centre, so that a
/// traversal meets each surfel once (NUMERICS 3.5); children stick out, hence the bound radii.
/// Siblings stand together, generation after generation, and families near in space stand near in
/// the file.
/// header.n_leaves and the page arrays are filled in. Throws DataError if there is no leaf.
/// Asks the source, of n surfels, twice: for the balls, then for the surfaces, which go to their
/// places one by one.
/// Cost: O(n log n); kTreeBytesPerSurfel a surfel, the result included.
SurfelTreeData build_tree(const SurfelSource& source, std::size_t n, const ModelHeader& header,
                          TreeCounts& counts);

/// The same of surfels in memory.
SurfelTreeData build_tree(std::span<const FittedSurfel> surfels, const ModelHeader& header,
                          TreeCounts& counts);

}  // namespace slim
