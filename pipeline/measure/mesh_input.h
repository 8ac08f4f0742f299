#pragma once

#include "slim/base/error.h"
#include "slim/smooth/mesh.h"

#include <cstdint>
#include <string>

namespace slim {

/// Whether the input is a PLY whose faces name their corners.
bool is_mesh(const std::string& path);

/// Vertices (minus the origin) and faces of such a PLY. DataError for more vertices than are
/// numbered.
Mesh read_mesh(const std::string& path, const Vec3d& origin);

DataError too_many_vertices(const std::string& path, std::uint64_t n);

}  // namespace slim
