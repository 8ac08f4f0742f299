#pragma once

#include "pipeline/job/job_source.h"
#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <string>

namespace slim {

/// `slim run JOB [CLOUD...]`.
using RunConfig = JobSource;

/// Runs a job's steps as child processes beside this one, each skipping what is up to date, and
/// writes its page. Fails as the step that failed, with its exit code.
nlohmann::json run_job(const RunConfig& config, StageContext& context);

/// For --print-config: the job as it would be run (resolved_job), a ready style without clouds as
/// its file has it; empty without a job.
std::string resolved_run(const RunConfig& config);

}  // namespace slim
