#pragma once

#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace slim {

/// `slim run JOB`.
struct RunConfig {
    std::string job;
    std::vector<std::string> settings;  ///< --set TABLE.KEY=VALUE

    template <class V>
    void visit(V&& field) {
        field.input("job", job, "job file (TOML): input, fit, views, measures and outputs");
        field.settings(settings);
    }
};

/// Runs a job's steps as child processes beside this one, each skipping what is up to date, and
/// writes its page. Fails as the step that failed, with its exit code.
nlohmann::json run_job(const RunConfig& config, StageContext& context);

}  // namespace slim
