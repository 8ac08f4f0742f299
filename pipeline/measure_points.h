#pragma once

#include "formats/ply_writer.h"
#include "formats/point_source.h"

#include <limits>
#include <span>
#include <string>
#include <vector>

namespace slim {

/// What is known of one measured point; NaN where it is not.
struct PointFigures {
    static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    double distance = kNone;  ///< signed along the normal (positive outside), model units
    double angle = kNone;     ///< between the normals, degrees
    double k1 = kNone, k2 = kNone, mean = kNone;  ///< model minus truth, 1 / length
};

/// The PLY of measure --per-point: see measure_cloud. Coordinates as double unless the cloud has floats.
class PointsFile {
public:
    PointsFile(const std::string& path, const CloudInfo& info, bool truth);
    void write(const PointChunk& chunk, std::span<const PointFigures> figures);
    void commit() { writer_.commit(); }

private:
    static PlyLayout layout_of(const CloudInfo& info, bool truth);

    Vec3d origin_;
    bool truth_;
    PlyWriter writer_;
    std::vector<Vec3d> local_;
    std::vector<float> scalars_;
};

}  // namespace slim
