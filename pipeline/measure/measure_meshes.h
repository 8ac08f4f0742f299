#pragma once

#include <nlohmann/json.hpp>

#include <string>

namespace slim {

/// Compares a mesh with what became of it, vertex by vertex: how far each is from where it was, and
/// how the faces' normals turned. The faces of the first count for both: some programs write them
/// in another order.
///
/// per_point  a PLY of the moved vertices with those faces, empty: none: scalar_distance (and
///            quality) how far a vertex is from where it was (model units), scalar_normal_angle the
///            mean of how far the faces about it turned, by their area in the first (degrees); NaN
///            where no face with an area is about it
/// returns  vertices, faces; l2, max, p50, p90, p95, p99: distances of the vertices over the
///          first's diagonal; max_at (the vertex of the first that went farthest, world); diagonal;
///          normal_mean_deg, normal_rms_deg (faces without area in either are left out, null if all
///          are) and faces_flat, how many those are
/// throws   DataError if the vertices are not as many, or one is not finite;
///          as read_mesh and AtomicFile
nlohmann::json compare_meshes(const std::string& original, const std::string& moved,
                              const std::string& per_point);

}  // namespace slim
