#pragma once

#include "slim/smooth/mesh.h"

#include <cstddef>

namespace slim {

/// What is known of a model whose leaves have one sheet,
/// to look for edges as a build with sharp leaves would.
struct SmoothModelRules {
    int degree = 2;               ///< of all leaves, or the highest that one chooses
    bool choose_degree = false;   ///< --degree auto
    double mdl_threshold = 0.01;  ///< T_MDL, over the diagonal
    double diagonal = 0;
    double noise_variance = 0;    ///< lambda
    double contrary_share = 0;    ///< of normals that noise turns out of a height field
    double spacing = 0;           ///< square root of the area that one of its
                                  ///< points has; 0: as the mesh's vertices have
};

/// How much of a mesh lies at edges.
struct EdgesSeen {
    std::size_t asked = 0;     ///< vertices that were looked at
    std::size_t at_edges = 0;  ///< of these, where two sheets or more describe 60
                               ///< vertices or more better than one does
    double share() const {
        return asked > 0 ? static_cast<double>(at_edges) / static_cast<double>(asked) : 0;
    }
    /// Whether the mesh has feature edges, which leaves of one sheet round off (notes/0008):
    /// more than 8 % of it.
    bool are_features() const;
};

/// Looks for feature edges about a random choice of a mesh's vertices (the same for any thread
/// count), with the search of `slim build --sharp on` (LeafMaker). Stops as soon as it is sure, at
/// 512 vertices at the latest; none of meshes without faces.
/// cost  0.2 ms a vertex that is looked at, once sorted;
///       about 200 bytes a vertex of the mesh while it runs
EdgesSeen feature_edges(const Mesh& mesh, const SmoothModelRules& model);

}  // namespace slim
