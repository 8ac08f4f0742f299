#pragma once

#include "formats/model_file.h"
#include "pipeline/stage.h"
#include "slim/tree/ball_index.h"

#include <nlohmann/json.hpp>

#include <string>

namespace slim {

/// How far a model's surface lies from a cloud, or from the faces of a mesh: the other way of
/// measuring. The surface is sampled as sample_surface says; every sample counts by the area that
/// it stands for.
///
/// Keys: to ("points" or "faces"), samples, area (model units, squared), l2, max, max_at (world),
/// p50 p90 p95 p99 (of samples), note (of points: what bounds the distances), within (share of the
/// area that has the cloud within `tolerance`). Distances over L, to the nearest point: never much
/// less than half the spacing of the points; to faces exact.
///
/// n_samples  about as many
/// throws     DataError if the model has no surface to sample; as open_cloud
/// cost       a cloud is read in chunks of a million points and not held: memory does not grow with
/// it, time by
///            2 us a sample and chunk that it may be near to; of a mesh 180 bytes a face are held
nlohmann::json measure_back(const ModelFile& model, const BallIndex& index,
                            const std::string& cloud, std::size_t n_samples, double tolerance,
                            StageContext& context);

}  // namespace slim
