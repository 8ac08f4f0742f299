#pragma once

#include "slim/base/vec.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// A polygon mesh as flat arrays; at most 2^32 - 1 vertices. Frame of the job.
struct Mesh {
    std::vector<Vec3d> position;
    std::vector<std::uint32_t> corner;        ///< vertices of all faces, one behind the other
    std::vector<std::size_t> face_end;        ///< in `corner`, of each face

    std::size_t n_faces() const { return face_end.size(); }
    std::span<const std::uint32_t> face(std::size_t f) const {
        const std::size_t begin = f == 0 ? 0 : face_end[f - 1];
        return std::span(corner).subspan(begin, face_end[f] - begin);
    }
    /// Corners must be vertices; a face of fewer than three has no area and counts for nothing.
    void add_face(std::span<const std::size_t> corners) {
        for (const std::size_t v : corners) corner.push_back(static_cast<std::uint32_t>(v));
        face_end.push_back(corner.size());
    }
};

/// The faces around every vertex, ascending; a face that names a vertex twice stands there twice.
class VertexFaces {
public:
    explicit VertexFaces(const Mesh& mesh);
    std::span<const std::uint32_t> of(std::size_t vertex) const {
        return std::span(faces_).subspan(begin_[vertex], begin_[vertex + 1] - begin_[vertex]);
    }

private:
    std::vector<std::size_t> begin_;
    std::vector<std::uint32_t> faces_;
};

/// Which vertices lie on an edge of one face only: 1, else 0.
std::vector<std::uint8_t> boundary_vertices(const Mesh& mesh);

}  // namespace slim
