#pragma once

#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <string>

namespace slim {

/// `slim run JOB`.
struct RunConfig {
    std::string job;

    template <class V>
    void visit(V&& field) {
        field.input("job", job, "job file (TOML): input, fit, views, measures and outputs");
    }
};

/// Runs a job's steps as child processes beside this one, each skipping what is up to date, and writes
/// its page. Fails as the step that failed, with its exit code.
nlohmann::json run_job(const RunConfig& config, StageContext& context);

}  // namespace slim
