#pragma once

#include "pipeline/measure/measure_cloud.h"
#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <string>

namespace slim {

/// How far the faces of a mesh lie from a surface, which their corners alone do not say: about
/// 200,000 samples, each for as much of the area, the same in every run, are put on it along their
/// face's normal. Concave faces count as what their outline holds.
///
/// A face's normal is to the side that its vertices' normals face, whichever way it is wound; by
/// its winding where they have none.
///
/// inwards  a mesh without normals is wound inwards: its normals are turned
/// returns  samples, area (of the faces, model units squared), missed (samples, as
///          measure_cloud has points), opposed (samples of faces whose normal the surface faces
///          away from), l2, max, max_at (world), p50 p90 p95 p99 (over L, of samples
///          that are not missed; null without any), completeness (the share of the area that has
///          the surface within `tolerance`); null if no face has an area
/// throws   as read_mesh
/// cost     24 bytes a vertex (12 more while normals are read) and 20 a triangle; 0.2 s for the
///          samples
nlohmann::json measure_faces(const MeasuredSurface& surface, const std::string& mesh, bool inwards,
                             double tolerance, StageContext& context);

}  // namespace slim
