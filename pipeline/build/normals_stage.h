#pragma once

#include "pipeline/build/plan_file.h"
#include "pipeline/build/slice_choice.h"
#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>

namespace slim {

/// Stage 2: every point of a slice gets an oriented normal, and the noise of the cloud is measured.
struct NormalsConfig : SliceChoice {
    std::string work;
    std::string normals = "auto";
    int neighbors = 0;
    std::string sensors;

    template <class Visitor>
    void visit(Visitor&& field) {
        field.input("work", work, "work folder of `slim slice`");
        SliceChoice::visit(field);
        field.choice(
            "normals", normals,
            "keep: take normals as they are; estimate: ignore them; auto: keep good ones, turn "
            "those that oppose their neighbours, estimate missing ones and all where they are "
            "those of no surface; flip: as auto, "
            "then all turned round",
            {"auto", "keep", "estimate", "flip"});
        field("neighbors", neighbors,
              "neighbours of a point that its normal is estimated from, 4 or more; 0: 16, and up "
              "to 64 where noise "
              "is thicker than they reach (by slice), twice as many where it hides their plane; "
              "where they lie on one scan line, twice as many until they do not",
              0, 200);
        field.path("sensors", sensors,
                   "JSON with the position of each scan's sensor, or the direction to it (as `slim "
                   "scan` writes); default: "
                   "<input>.scans.json beside an input, if there");
    }
};

/// throws ConfigError if normals are kept and an option says how to estimate them
void check_normals_config(const NormalsConfig& config);

/// WORK/slice_0007/oriented.slice: the points with a normal each.
std::filesystem::path oriented_points_path(const std::filesystem::path& work, std::size_t slice);

/// Writes oriented.slice of each slice, its points along the Morton curve of the whole job's box.
/// Where all normals are estimated, a slice takes their signs from the one before (IncompleteError
/// if that one is missing) and from a sample of the whole (scene_signs.h), so that an object cut in
/// slices has one outside. The result counts, per
/// cause, what was kept, turned and estimated, and holds the slice's share of lambda (noise).
/// Cost: a core works 0.3 us a point on oriented clouds and 1.2 to 2.6 us where normals are
/// estimated, 7 in noise of 1 %; memory: 81 and 165 to 210 bytes a point of a slice.
nlohmann::json run_normals(const NormalsConfig& config, StageContext& context);

}  // namespace slim
