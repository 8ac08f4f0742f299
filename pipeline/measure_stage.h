#pragma once

#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <string>

namespace slim {

/// How far a cloud lies from a model.
struct MeasureConfig {
    std::string model, cloud, truth, output;

    template <class Visitor>
    void visit(Visitor&& field) {
        field.input("model", model, "model.slim");
        field.input("cloud", cloud, "cloud to project onto the model");
        field.optional_output("output", output,
                              "JSON file for the result (with a manifest: up to date is not measured again)");
        field.path("truth", truth,
                   "exact normals and curvatures (doubles nx ny nz k1 k2 a point); default: "
                   "<cloud>.truth, if there");
    }
};

/// Projects every finite point of the cloud along its normal (NUMERICS 5.5; the model's own normal
/// where it has none). Keys: points missed l2 max max_at (the point of the cloud that is farthest,
/// world) normal_rms_deg leaves bytes; with truth also k1_rms k2_rms
/// mean_curvature_rms (1 / length) and the same with _x_diagonal.
/// A point whose normal's line finds the surface only against the normal is counted as `opposed`,
/// the normals compared without sign (scans hold some flipped normals). One that is supported but
/// whose line meets nothing in reach, the normal running along the surface, is counted as `astray`
/// and projected along the model's normal. A point is missed if no surfel supports it or neither
/// line meets the surface in reach. A mean over nothing is null. throws DataError if the cloud has
/// no finite point
nlohmann::json run_measure(const MeasureConfig& config, StageContext& context);

}  // namespace slim
