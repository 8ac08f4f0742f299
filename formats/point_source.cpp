#include "formats/point_source.h"

#include "formats/byte_reader.h"
#include "formats/cloud_kind.h"
#include "formats/ply_face_normals.h"
#include "formats/ply_reader.h"
#include "formats/xyz_reader.h"

namespace slim {
namespace {

CloudKind kind_of(const std::string& path) {
    ByteReader in(path);
    return cloud_kind(path, in.peek(4096).substr(0, 4096));
}

}  // namespace

std::unique_ptr<PointSource> open_cloud(const std::string& path, bool face_points) {
    if (kind_of(path) == CloudKind::ply) return open_ply(path, face_points);
    return std::make_unique<XyzReader>(path);
}

std::unique_ptr<PointSource> open_colored_cloud(const std::string& path) {
    if (kind_of(path) != CloudKind::ply) return nullptr;
    auto reader = std::make_unique<PlyReader>(path);
    if (!reader->ask_for_color()) return nullptr;
    return reader;
}

}  // namespace slim
