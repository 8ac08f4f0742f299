#pragma once

#include "pipeline/measure/apart.h"
#include "pipeline/stage.h"
#include "slim/base/log_histogram.h"
#include "slim/blend/blend.h"
#include "slim/smooth/point_projector.h"

#include <nlohmann/json.hpp>

#include <functional>
#include <string>

namespace slim {

/// What a cloud is measured against: puts points, frame of the job, on a surface. One a thread.
using PutPoint =
    std::function<ProjectedPoint(const Vec3d& p, const Vec3d& own_normal, bool curvature)>;

struct MeasuredSurface {
    Vec3d origin;                             ///< world minus frame of the job
    double diagonal = 0;                      ///< L
    std::function<PutPoint()> new_projector;  ///< for one thread
    bool corners_may_miss = false;            ///< the cloud is a mesh whose faces
                                              ///< are measured to as well
    PlacedFile file = {};                     ///< the model's; a shape has none
};

/// Where the cloud, its truth and the figures of its points lie; empty: none.
struct CloudFiles {
    std::string cloud, truth, per_point;
};

/// Measures a cloud in one pass, in chunks of 262,144 points with their truth (memory does not grow
/// with the cloud, but with a mesh's faces: measure_faces.h); the keys of run_measure but leaves,
/// bytes and diagonal.
///
/// per_point  a PLY of the cloud's points, all of them and in their order, with its normals and, as
///            floats (CONVENTIONS 1.5): scalar_distance (signed along the normal, model units),
///            scalar_normal_angle (degrees, where there is a normal or truth), with truth
///            scalar_k1_error, scalar_k2_error and scalar_mean_curvature_error (model minus truth),
///            and quality, the distance again, which other programs show. NaN where a point is
///            missed.
/// throws     DataError without a finite point; NumericalError (of a model: refuse_apart) if every
///            one is missed (of corners that may miss: and the boxes do not meet), before per_point
///            is there; FormatError if the truth is not of this cloud;
///            IoError as open_cloud and AtomicFile
nlohmann::json measure_cloud(const MeasuredSurface& surface, const CloudFiles& files,
                             double tolerance, StageContext& context);

/// Share of L that distances are given in, for percentiles p50 p90 p95 p99 of `out`.
void put_percentiles(const LogHistogram& distances, double diagonal, nlohmann::json& out);

/// sqrt(sum / n) / unit; null where there is nothing to take a mean of: 0 would be the best score.
nlohmann::json rms(double sum, double n, double unit = 1);

}  // namespace slim
