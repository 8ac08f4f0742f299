#include "pipeline/measure/mesh_input.h"

#include "formats/byte_reader.h"
#include "formats/cloud_kind.h"
#include "formats/ply_faces.h"
#include "formats/ply_reader.h"

#include <fmt/format.h>

#include <limits>
#include <span>

namespace slim {
namespace {

constexpr std::size_t kChunk = 1 << 18;

}  // namespace

bool is_mesh(const std::string& path) {
    if (cloud_kind(path, ByteReader(path).peek(4096).substr(0, 4096)) != CloudKind::ply)
        return false;
    const PlyReader reader(path);
    return reader.info().has_faces() && reader.has_corner_lists();
}

DataError too_many_vertices(const std::string& path, std::uint64_t n) {
    return DataError(fmt::format("{}: a mesh of {} vertices; at most 4294967294 are taken as one "
                                 "(slim smooth --mode points takes more)",
                                 path, n));
}

Mesh read_mesh(const std::string& path, const Vec3d& origin) {
    Mesh mesh;
    PlyReader vertices(path);
    for (PointChunk chunk; vertices.read(chunk, kChunk);)
        for (const Vec3d& p : chunk.position) mesh.position.push_back(p - origin);
    if (mesh.position.size() >= std::numeric_limits<std::uint32_t>::max())
        throw too_many_vertices(path, mesh.position.size());
    read_ply_faces(path, mesh.position.size(), [&](auto corners) { mesh.add_face(corners); });
    return mesh;
}

}  // namespace slim
