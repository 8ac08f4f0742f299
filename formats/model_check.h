#pragma once

#include "slim/model/surfel_tree.h"

#include <string>

namespace slim {

/// Where and why a tree is no tree of ours; `chunk` is empty if it is sound.
struct ModelFault {
    std::string chunk;  ///< "header", "drawn", "pages", "records", "nodes", "sharp" or "sheets"
    std::size_t entry = 0;    ///< index in that chunk
    std::string reason;
};

/// Checks what rendering relies on: the arrays fit together; children lie in bounds and behind
/// their parent, every node but the root has exactly one (so there is no cycle); records are
/// finite, radii positive, every bound holds its ball and its children's bounds; level and degree
/// in range; as many leaves as the header says; further sheets are those of the nodes flagged
/// sharp, in order.
/// cost O(nodes), reads every record
ModelFault check_model(const SurfelTree& tree);

/// Of check_model what needs neither nodes nor records: header, sizes, and that every record lies
/// inside the records.
/// cost O(pages), with records of unequal size O(nodes)
ModelFault check_sizes(const SurfelTree& tree);

/// Of check_model what one node and its record say of themselves, for a tree that check_sizes found
/// sound.
ModelFault check_alone(const SurfelTree& tree, std::size_t node);

}  // namespace slim
