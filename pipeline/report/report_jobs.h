#pragma once

#include "pipeline/job/job.h"
#include "pipeline/report/report_results.h"
#include "pipeline/stage.h"

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace slim {

/// Whether a TOML file is an ordinary job (docs/job.md) rather than a report file: it has tables of
/// a job and no experiment. ConfigError if it is not TOML.
bool is_ordinary_job(const std::filesystem::path& file);

/// Reads ordinary jobs for a report: each writes into folder/<its name>, and is measured whether it
/// has a [measure] or not. `settings` (TABLE.KEY=VALUE) change every one. ConfigError as read_job,
/// and for two jobs of one name; IoError for an input that is not there.
std::vector<Job> read_report_jobs(const std::vector<std::string>& files,
                                  const std::filesystem::path& folder,
                                  const std::vector<std::string>& settings);

/// Jobs as an experiment of one row each: the model's size, seconds by stage, errors, frame times
/// and pictures; error over run time as plots.
ReportFile experiment_of_jobs(const std::vector<Job>& jobs);

/// How many steps were run, and found up to date.
struct StepCounts {
    std::size_t run = 0, reused = 0;
};

/// Runs the jobs' steps, as `slim run` does, for that experiment. A step that fails ends its job,
/// whose row lacks what follows; the other jobs go on. Adds to the counts. throws Interrupted
ExperimentResult run_jobs(const Experiment& experiment, const std::vector<Job>& jobs,
                          StageContext& context, StepCounts& counts);

}  // namespace slim
