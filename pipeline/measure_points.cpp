#include "pipeline/measure_points.h"

#include "formats/extension.h"
#include "slim/base/error.h"

namespace slim {

PointsFile::PointsFile(const std::string& path, const CloudInfo& info, bool truth)
    : origin_(info.origin.value_or(Vec3d{})), truth_(truth), writer_(path, layout_of(info, truth)) {
    if (lower_extension(path) != ".ply")
        throw ConfigError(path + ": the figures of points are a PLY; expected a name ending in .ply");
}

PlyLayout PointsFile::layout_of(const CloudInfo& info, bool truth) {
    PlyLayout layout;
    layout.double_positions = info.coordinates != CoordinateType::float32;
    layout.normals = info.has_normals;
    layout.scan = info.has_scan;
    layout.scalars = {"scalar_distance", "scalar_normal_angle"};
    if (truth)
        for (const char* name : {"k1", "k2", "mean_curvature"})
            layout.scalars.push_back(std::string("scalar_") + name + "_error");
    layout.scalars.push_back("quality");
    layout.origin = info.origin;
    layout.comments.push_back("slim measure: distance in model units, positive outside; angles in degrees; "
                              "nan: missed");
    return layout;
}

void PointsFile::write(const PointChunk& chunk, std::span<const PointFigures> figures) {
    local_ = chunk.position;
    for (Vec3d& p : local_) p -= origin_;
    scalars_.clear();
    for (const PointFigures& f : figures) {
        scalars_.push_back(static_cast<float>(f.distance));
        scalars_.push_back(static_cast<float>(f.angle));
        if (truth_)
            for (const double error : {f.k1, f.k2, f.mean})
                scalars_.push_back(static_cast<float>(error));
        scalars_.push_back(static_cast<float>(f.distance));
    }
    writer_.write({local_, chunk.normal, {}, chunk.scan, scalars_});
}

}  // namespace slim
