#pragma once

#include "slim/smooth/mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// Faces that vertices turn over or across the surface on their way, and what was done about it.
struct TurnedFaces {
    std::uint64_t turned = 0;       ///< that would have been
    std::uint64_t n_held_back = 0;  ///< vertices that go a share of their way, or stay
    std::vector<std::uint32_t> kept;  ///< those that stay, rising
};

/// Keeps faces from turning over: the corners of a face that was less than 72 degrees off `toward`
/// at `from` and would be more at `to` go half of their way, a quarter, an eighth, or stay, until
/// none is.
/// `mesh` says how vertices hang together, its positions do not count; toward: of each face, the
/// way it should face, or zero: its own. Normals of polygons are those of their fan.
/// Cost: one pass over the faces and one over those about the vertices that were held back, a
/// round; 4 bytes a vertex.
TurnedFaces hold_back_turned(const Mesh& mesh, const VertexFaces& around,
                             std::span<const Vec3f> toward, std::span<const Vec3d> from,
                             std::vector<Vec3d>& to);

}  // namespace slim
