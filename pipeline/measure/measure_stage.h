#pragma once

#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace slim {

/// How far a cloud lies from a model and a model from a cloud; a picture from another; a mesh from
/// what became of it.
struct MeasureConfig {
    std::string model, cloud, truth, per_point, output;
    bool two_way = false;
    double tolerance = 0.001;
    std::uint64_t samples = 200'000;
    double threshold = 1.0 / 255;
    std::vector<double> offset;

    template <class Visitor>
    void visit(Visitor&& field) {
        field.input("model", model,
                    "model.slim, shape:NAME (an analytic shape of slim scan), a picture, a mesh "
                    "(PLY) or a cloud");
        field.input("cloud", cloud,
                    "cloud to project onto the model, a picture of the same size, or the mesh or "
                    "cloud with its points moved");
        field.optional_output("output", output,
                              "JSON file (.json) for the result (with a manifest: up to date is "
                              "not measured again); of pictures also x.png: their difference");
        field.path("truth", truth,
                   "exact normals and curvatures (doubles nx ny nz k1 k2 a point); default: "
                   "<cloud>.truth, if there");
        field.path(
            "per_point", per_point,
            "PLY for the figures of every point or vertex: scalar_distance (also as quality), "
            "scalar_normal_angle, ...");
        field("two_way", two_way,
              "also from the model to the cloud's faces; to its nearest points if it has none, so "
              "that these distances are not below the points' spacing; of two clouds: to the "
              "nearest points, both ways");
        field("tolerance", tolerance,
              "of completeness and within: a distance over the diagonal L (the model's, the first "
              "cloud's)",
              0, 1);
        field("samples", samples, "points on the model's surface (--two-way): about as many", 1,
              1e9);
        field("threshold", threshold, "of pictures: a pixel differs if a channel differs by more",
              0, 1e30);
        field("offset", offset,
              "of shape:NAME: where the shape's origin lies in the world, x,y,z (as slim scan "
              "--offset moved it)");
    }
};

/// The name that --per-point gives, which must end in .ply (ConfigError).
void check_per_point(const MeasureConfig& config);

/// All that can be told of the options of a cloud against a model before either is opened: readers
/// of jobs ask, too. ConfigError.
void check_measure_options(const MeasureConfig& config);

/// Projects every finite point of the cloud along its normal (NUMERICS 5.5; the model's own normal
/// where it has none). Keys: points missed l2 max max_at (the point of the cloud that is farthest,
/// world) p50 p90 p95 p99 normal_rms_deg normal_p99_deg leaves bytes; with truth also k1_rms k2_rms
/// mean_curvature_rms (1 / length) and the same with _x_diagonal; completeness: the share of the
/// finite points that have the model within `tolerance`; of a mesh with faces the share of their
/// area, and `faces`, how far that lies from the model (measure_faces.h): points are its vertices.
/// A point whose normal's line finds the surface only against the normal is counted as `opposed`,
/// the normals compared without sign (scans hold some flipped normals). One that is supported but
/// whose line meets nothing in reach, the normal running along the surface, is counted as `astray`
/// and projected along the model's normal. A point is missed if no surfel supports it or neither
/// line meets the surface in reach; against a shape, if its nearest point is not known
/// (nearest_point), with a warning. A mean over nothing is null.
///
/// two_way adds model_to_cloud (measure_back.h). Two pictures are compared as measure_pictures.h
/// says, a mesh in place of the model and what became of it vertex by vertex as measure_meshes.h
/// says, two clouds as measure_clouds.h does. Names of outputs with another ending than they are
/// written with are refused before any work (ConfigError).
/// throws DataError if the cloud has no finite point; NumericalError if the model misses every one,
///        as in another frame or unit: then nothing is written
nlohmann::json run_measure(const MeasureConfig& config, StageContext& context);

}  // namespace slim
