#include "slim/smooth/mesh.h"

#include <algorithm>

namespace slim {

VertexFaces::VertexFaces(const Mesh& mesh)
    : begin_(mesh.position.size() + 1), faces_(mesh.corner.size()) {
    for (const std::uint32_t v : mesh.corner) ++begin_[v + 1];
    for (std::size_t v = 1; v < begin_.size(); ++v) begin_[v] += begin_[v - 1];
    std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
    for (std::size_t f = 0; f < mesh.n_faces(); ++f)
        for (const std::uint32_t v : mesh.face(f))
            faces_[next[v]++] = static_cast<std::uint32_t>(f);
}

std::vector<std::uint8_t> boundary_vertices(const Mesh& mesh) {
    std::vector<std::uint64_t> edges;
    edges.reserve(mesh.corner.size());
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        const auto corners = mesh.face(f);
        if (corners.size() < 3) continue;
        for (std::size_t k = 0; k < corners.size(); ++k) {
            const std::uint64_t a = corners[k], b = corners[(k + 1) % corners.size()];
            edges.push_back(std::min(a, b) << 32 | std::max(a, b));
        }
    }
    std::sort(edges.begin(), edges.end());
    std::vector<std::uint8_t> boundary(mesh.position.size());
    for (std::size_t i = 0; i < edges.size();) {
        std::size_t end = i + 1;
        while (end < edges.size() && edges[end] == edges[i]) ++end;
        if (end == i + 1) boundary[edges[i] >> 32] = boundary[edges[i] & 0xffffffffu] = 1;
        i = end;
    }
    return boundary;
}

}  // namespace slim
