#pragma once

#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace slim {

/// The stages slice, normals, fit and tree in one go.
struct BuildConfig {
    std::vector<std::string> inputs;
    std::string output;
    std::string degree = "2";
    double t_mdl = 0.01;
    double lambda = 0;
    std::string radius_rule = "ladder";
    std::string weight = "gauss";
    std::string cover = "B";
    std::string sharp = "off";
    std::string normals = "auto";
    std::string sensors;
    std::string memory = "1GiB";
    int slices = 0;
    bool strict = false;
    std::string work;
    std::uint64_t seed = 0;

    template <class Visitor>
    void visit(Visitor&& field) {
        field.input("inputs", inputs,
                    "point clouds: PLY or text (.xyz .txt .asc .pts .csv), .gz allowed");
        field.output("output", output, "model to write (model.slim)");
        field.choice("degree", degree,
                     "polynomial degree of a surfel; auto: of each, the one that takes the fewest bytes "
                     "for its error",
                     {"1", "2", "3", "auto"});
        field("t_mdl", t_mdl,
              "T_MDL of eq. (3), fraction of the diagonal: larger is sparser and smoother", 1e-12, 1e3);
        field("lambda", lambda, "noise variance of eq. (3), model units squared; 0: measured", 0, 1e300);
        field.choice("radius_rule", radius_rule,
                     "how a surfel's radius is found; windows: the paper's, for comparison",
                     {"ladder", "windows"});
        field.choice("weight", weight,
                     "of the points in a fit; gauss: the paper's, polynomial: (1 - r^2)^4",
                     {"gauss", "polynomial"});
        field.choice("cover", cover,
                     "how far a leaf covers; A: the paper to the letter, B: G up to its radius, C: a B-spline",
                     {"A", "B", "C"});
        field.choice("sharp", sharp,
                     "on: edges and corners get surfels of two or three sheets where that takes fewer bytes",
                     {"on", "off"});
        field.choice("normals", normals,
                     "keep: as they are; estimate: ignore them; auto: keep good ones, mend bad ones",
                     {"auto", "keep", "estimate"});
        field.path("sensors", sensors,
                   "JSON with sensor positions per scan; default: <input>.scans.json, if there");
        field("memory", memory, "memory for one slice, at least 64MiB: a larger cloud is cut into slices");
        field("slices", slices, "number of slices; 0: as many as the memory asks for", 0, 500);
        field("strict", strict, "refuse clouds with non-finite points instead of dropping these");
        field.path("work", work,
                   "folder for intermediate files, kept; default: <output>.work, removed at the end");
        field("seed", seed, "chooses among equally good centres");
    }
};

/// Cloud to model. A killed build resumes at the last stage (of the last slice) that ended; a second one into
/// the same work folder fails at once (75). context.text: a short summary.
/// throws what the stages throw
nlohmann::json run_build(const BuildConfig& config, StageContext& context);

}  // namespace slim
