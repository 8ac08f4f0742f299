#pragma once

#include "pipeline/plan_file.h"
#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>

namespace slim {

/// Stage 2: every point of a slice gets an oriented normal, and the noise of the cloud is measured.
struct NormalsConfig {
    std::string work;
    int slice = -1;
    std::string normals = "auto";
    int neighbors = 16;
    std::string sensors;

    template <class Visitor>
    void visit(Visitor&& field) {
        field.input("work", work, "work folder of `slim slice`");
        field.part("slice", slice, "number of the slice; -1: the array job's index, else all", -1,
                   100000);
        field.choice("normals", normals,
                     "keep: take normals as they are; estimate: ignore them; auto: keep good ones, turn "
                     "those that oppose their neighbours, estimate missing ones",
                     {"auto", "keep", "estimate"});
        field("neighbors", neighbors, "neighbours of a point that its normal is estimated from", 4,
              200);
        field.path("sensors", sensors,
                   "JSON with the position of each scan's sensor, or the direction to it (as `slim scan` writes); default: "
                   "<input>.scans.json beside an input, if there");
    }
};

/// WORK/slice_0007/oriented.slice: the points with a normal each.
std::filesystem::path oriented_points_path(const std::filesystem::path& work, std::size_t slice);

/// --slice of a stage called inside another: all, whatever array job the whole build is part of.
inline constexpr int kAllSlices = -2;

/// Slices to work on: `slice` if >= 0; -1: the index an array job was given (SLURM_ARRAY_TASK_ID,
/// ...), else all. ConfigError if there is no such slice.
std::vector<std::size_t> slices_to_do(int slice, const SlicePlan& plan);

/// Writes oriented.slice of each slice, its points along the Morton curve of the whole job's box.
/// Where all normals are estimated, a slice takes their signs from the one before (IncompleteError
/// if that one is missing), so that an object cut in slices has one outside. The result counts, per
/// cause, what was kept, turned and estimated, and holds the slice's share of lambda (noise).
/// Cost: a core works 0.4 us a point on oriented clouds and 1.5 us where normals are estimated;
/// memory: 81 and 136 bytes a point of a slice.
nlohmann::json run_normals(const NormalsConfig& config, StageContext& context);

}  // namespace slim
