#pragma once

#include "pipeline/job/job_source.h"
#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

namespace slim {

/// `slim run JOB [CLOUD...]`.
using RunConfig = JobSource;

/// Runs a job's steps as child processes beside this one, each skipping what is up to date, and
/// writes its page. Fails as the step that failed, with its exit code.
nlohmann::json run_job(const RunConfig& config, StageContext& context);

}  // namespace slim
