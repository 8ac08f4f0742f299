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
        field.input("file", file,
                    "model.slim, a slice, a fit, a cloud, or another file of ours: JSON, a picture, "
                    "a truth, a drawing, lines in space, a table, a job, a plan, a page");
    }
};

/// What is in the file: "kind" (model, slice, fit, cloud, lines, or one of record_info's and
/// other_info's), counts,
/// bounds (world), origin, attributes, provenance and health. Reads all of a
/// model, a slice, a fit, a truth and a cloud, so that checksums and points are checked.
nlohmann::json run_info(const InfoConfig& config, StageContext& context);

}  // namespace slim
