#include "pipeline/measure/measure_points.h"

namespace slim {

PointsFile::PointsFile(const std::string& path, const CloudInfo& info, const PointsFileKind& kind)
    : origin_(info.origin.value_or(Vec3d{})), kind_(kind), writer_(path, layout_of(info, kind)) {}

PlyLayout PointsFile::layout_of(const CloudInfo& info, const PointsFileKind& kind) {
    PlyLayout layout;
    layout.double_positions = info.coordinates != CoordinateType::float32;
    layout.normals = info.has_normals;
    layout.scan = info.has_scan;
    layout.scalars = {"scalar_distance", "scalar_normal_angle"};
    if (kind.truth)
        for (const char* name : {"k1", "k2", "mean_curvature"})
            layout.scalars.push_back(std::string("scalar_") + name + "_error");
    layout.scalars.push_back("quality");
    layout.origin = info.origin;
    layout.comments.push_back("slim measure: " + kind.meaning);
    if (!kind.faces) return layout;
    layout.n_faces = kind.faces->n_faces();
    for (std::size_t f = 0; f < kind.faces->n_faces(); ++f)
        layout.large_faces |= kind.faces->face(f).size() > 255;
    return layout;
}

void PointsFile::write(const PointChunk& chunk, std::span<const PointFigures> figures) {
    local_ = chunk.position;
    for (Vec3d& p : local_) p -= origin_;
    scalars_.clear();
    for (const PointFigures& f : figures) {
        scalars_.push_back(static_cast<float>(f.distance));
        scalars_.push_back(static_cast<float>(f.angle));
        if (kind_.truth)
            for (const double error : {f.k1, f.k2, f.mean})
                scalars_.push_back(static_cast<float>(error));
        scalars_.push_back(static_cast<float>(f.distance));
    }
    writer_.write({local_, chunk.normal, {}, chunk.scan, scalars_});
}

void PointsFile::commit() {
    if (kind_.faces)
        for (std::size_t f = 0; f < kind_.faces->n_faces(); ++f)
            writer_.write_face(kind_.faces->face(f));
    writer_.commit();
}

}  // namespace slim
