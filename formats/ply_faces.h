#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>

namespace slim {

/// Gives the corners of every face of a PLY, in file order, as vertex numbers below n_vertices;
/// faces of fewer than three corners too. Nothing if no face names its corners.
/// throws FormatError naming the face and the index when an index is out of range, and as PlyRows
void read_ply_faces(const std::string& path, std::size_t n_vertices,
                    const std::function<void(std::span<const std::size_t> corners)>& take);

}  // namespace slim
