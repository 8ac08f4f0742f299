#pragma once

#include "pipeline/build/face_points_option.h"
#include "pipeline/build/fit_options.h"
#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace slim {

/// The stages slice, normals, fit and tree in one go.
struct BuildConfig : FitOptions {
    std::vector<std::string> inputs;
    std::string output;
    std::string normals = "auto";
    std::string sensors;
    std::string memory = "1GiB";
    int slices = 0;
    bool strict = false;
    std::string face_points = "on";
    std::string work;
    std::uint64_t seed = 0;
    bool color = false;

    template <class Visitor>
    void visit(Visitor&& field) {
        field.input("inputs", inputs,
                    "point clouds: PLY or text (.xyz .txt .asc .pts .csv), .gz allowed");
        field.output("output", output, "model to write (model.slim)");
        FitOptions::visit(field);
        field.choice("normals", normals,
                     "keep: as they are; estimate: ignore them; auto: keep good ones, mend bad "
                     "ones; flip: as auto, then all turned round",
                     {"auto", "keep", "estimate", "flip"});
        field.path("sensors", sensors,
                   "JSON with sensor positions per scan; default: <input>.scans.json, if there");
        field("memory", memory,
              "memory for points, at least 64MiB: a larger cloud is cut into slices");
        field("slices", slices, "number of slices; 0: as many as the memory asks for", 0, 500);
        visit_face_points(field, face_points);
        field("strict", strict, "refuse clouds with non-finite points instead of dropping these");
        field.path("work", work,
                   "folder for intermediate files, kept; default: <output>.work, removed if a "
                   "build made it");
        field("seed", seed, "chooses among equally good centres");
        field("color", color,
              "keep the colours of the clouds (PLY: red green blue), for slim render --aov color: "
              "18 bytes a surfel");
    }
};

/// Cloud to model. A killed build resumes at the last stage (of the last slice) that ended; a
/// second one into the same work folder fails at once (75). context.text: a short summary.
/// throws what the stages throw
nlohmann::json run_build(const BuildConfig& config, StageContext& context);

}  // namespace slim
