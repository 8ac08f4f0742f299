#pragma once

#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <string>

namespace slim {

/// `slim info FILE`.
struct InfoConfig {
    std::string file;

    template <class V>
    void visit(V&& field) {
        field.input("file", file, "model.slim, a slice, a fit, one of our JSON files, or a cloud");
    }
};

/// What is in the file: "kind" (model, slice, fit, json, cloud), counts, bounds (world), origin,
/// attributes, provenance and health. Reads all of it, so that checksums and points are checked.
nlohmann::json run_info(const InfoConfig& config, StageContext& context);

}  // namespace slim
