#pragma once

#include "pipeline/build/face_points_option.h"
#include "pipeline/build/plan_file.h"
#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace slim {

/// Stage 1: clouds to slices of bounded size with one origin.
struct SliceConfig {
    std::vector<std::string> inputs;
    std::string work;
    std::string memory = "1GiB";
    int slices = 0;
    bool strict = false;
    std::string face_points = "on";

    template <class Visitor>
    void visit(Visitor&& field) {
        field.input("inputs", inputs,
                    "point clouds: PLY or text (.xyz .txt .asc .pts .csv), .gz allowed");
        field.output("work", work, "folder for the slices and plan.json");
        field("memory", memory, "memory that later stages may use for one slice");
        field("slices", slices, "number of slices; 0: as many as the memory asks for", 0, 500);
        visit_face_points(field, face_points);
        field("strict", strict, "refuse clouds with non-finite points instead of dropping these");
    }
};

/// The origin of a whole job: zero if the coordinates are small anyway (at most 4 L); else the
/// centre rounded to a multiple of a power of two near L, so that subtracting it loses no bit of a
/// float.
Vec3d choose_origin(const Bbox& world_bounds);

/// throws ConfigError if a build cannot do with so little
void check_slice_memory(const std::string& memory);

/// Reads all inputs once if they fit into one slice, which is kept meanwhile; else twice: bounds
/// and counts first, then deals the points out to
/// WORK/slice_NNNN/points.slice, ordered by id (the number of the point among all of all inputs,
/// those dropped included); writes WORK/plan.json last. Returns what the plan says, in short.
/// throws DataError without a finite point or with a diagonal beyond 1e-12 to 1e12; what the
/// readers throw
/// cost   memory: 46 bytes a point of what one slice may hold; beyond, two chunks, 4 MiB of cells
///        and one open file a slice
nlohmann::json run_slice(const SliceConfig& config, StageContext& context);

}  // namespace slim
