#pragma once

#include "slim/base/bbox.h"
#include "slim/model/surfel_tree.h"

#include <cstdint>
#include <vector>

namespace slim {

/// Box of what pictures show of a model, local frame: of its leaves' cores (with `loose`, of loose
/// ones too), cut off where the input points end. Where every point is covered this is the points'
/// own box; strays that the fit left out do not stretch it. The points' box if nothing is drawn.
///
/// cost  none where the header has it (set_drawn_bounds); else the nodes that may reach beyond what
///       is found already: hundreds of a million of a round model, all of a flat one that strays
///       surround. `visited` gets their numbers if it is given
/// throws FormatError if the nodes are no tree
Bbox drawn_bounds(const SurfelTree& tree, bool loose,
                  std::vector<std::uint32_t>* visited = nullptr);

/// Puts both boxes into the header, without and with loose leaves: the same to the last bit; and
/// the hulls of both (drawn_hull.h). cost O(nodes), reads every record
void set_drawn_bounds(SurfelTreeData& data);

}  // namespace slim
