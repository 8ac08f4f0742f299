#pragma once

#include "formats/ply_reader.h"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace slim {

/// A PLY with faces and no normals: the whole mesh is read at once, and every vertex gets the
/// area-weighted mean of its faces' normals, of unit length; zero if no face uses it. Those of a
/// closed mesh point outwards, however its faces are wound.
/// throws FormatError naming the face and the index when an index is out of range
/// face_points: points on its large faces follow its vertices (FacePoints).
class PlyFaceNormals : public PointSource {
public:
    explicit PlyFaceNormals(PlyReader& vertices, bool face_points = false);
    bool read(PointChunk& out, std::size_t max_points) override;
    std::uint64_t bytes_read() const override { return info_.file_size; }

private:
    void find_middle();
    bool wound_inwards() const;
    void add_polygon(std::span<const std::size_t> corners);
    void add_face_points();

    PointChunk all_;
    std::vector<Vec3d> sums_;
    std::size_t n_given_ = 0;
    Vec3d area_;         ///< twice the sum of the faces' area vectors: zero if they close
    /// six times what they enclose, seen from middle_; negative if wound inwards
    double volume_ = 0;
    Vec3d middle_;
    double reach_ = 0;   ///< of the points from middle_
};

/// Opens a PLY in the way that its header asks for.
std::unique_ptr<PointSource> open_ply(const std::string& path, bool face_points = false);

}  // namespace slim
