#pragma once

#include "formats/ply_writer.h"
#include "formats/point_source.h"
#include "slim/smooth/mesh.h"

#include <limits>
#include <span>
#include <string>
#include <vector>

namespace slim {

/// What is known of one measured point; NaN where it is not.
struct PointFigures {
    static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    double distance = kNone;  ///< to a model signed along the normal
                              ///< (positive outside), model units
    double angle = kNone;     ///< between the normals, degrees
    double k1 = kNone, k2 = kNone, mean = kNone;  ///< model minus truth, 1 / length
};

/// What a file of figures says beside them.
struct PointsFileKind {
    bool truth = false;          ///< with the errors of curvature
    const Mesh* faces = nullptr; ///< whose faces follow the points; must outlive the file
    std::string meaning =
        "distance in model units, positive outside; angles in degrees; nan: missed";
};

/// The PLY of measure --per-point: see measure_cloud. Coordinates as double unless the cloud has
/// floats.
class PointsFile {
public:
    PointsFile(const std::string& path, const CloudInfo& info, const PointsFileKind& kind);
    void write(const PointChunk& chunk, std::span<const PointFigures> figures);
    void commit();

private:
    static PlyLayout layout_of(const CloudInfo& info, const PointsFileKind& kind);

    Vec3d origin_;
    PointsFileKind kind_;
    PlyWriter writer_;
    std::vector<Vec3d> local_;
    std::vector<float> scalars_;
};

}  // namespace slim
