#pragma once

#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <string>

namespace slim {

/// Stage 4: the fits of all slices become one model file.
struct TreeConfig {
    std::string work;
    std::string output;
    std::string memory = "1GiB";

    template <class Visitor>
    void visit(Visitor&& field) {
        field.input("work", work, "work folder whose slices are fitted");
        field.output("output", output, "model to write (model.slim)");
        field("memory", memory,
              "memory above which the tree says so; it takes what its surfels need");
    }
};

/// Warns where the surfels ask for more than config.memory; what they ask for is known before the
/// tree is made. Merges the fits, links the ball tree and writes the model; equal fits give equal
/// bytes.
/// Its manifest is <output>.done.json, within a build tree.done.json in the work folder.
/// throws IncompleteError (exit 6) naming slices without a fit, or fits made with different
/// settings;
///        DataError if no surfel was found
nlohmann::json run_tree(const TreeConfig& config, StageContext& context);

}  // namespace slim
