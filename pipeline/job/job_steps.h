#pragma once

#include "pipeline/job/job.h"
#include "pipeline/stage.h"
#include "pipeline/told_error.h"
#include "slim/base/error.h"

#include <nlohmann/json.hpp>

#include <string>
#include <utility>
#include <vector>

namespace slim {

/// What a step of a job came to: its --json object and what it cost, as its manifest records it,
/// which is the cost of an earlier run if the output was up to date.
struct StepOutcome {
    JobStep step;
    nlohmann::json result;
    bool up_to_date = false;
    double seconds = 0;
    double peak_memory_bytes = 0;
    std::string run_started = {};  ///< of the run that this is the cost of; empty: not said
};

/// A step that failed: its exit code, what() with the step's name first, and without it.
struct StepError : ToldError {
    StepError(ExitCode code, const std::string& step, std::string its_reason, Fault its_parts)
        : ToldError(code, step + ": " + its_reason, std::move(its_parts)),
          reason(std::move(its_reason)) {}
    std::string reason;
};

/// Runs a step as a child process beside this one, which skips what is up to date. Throws
/// StepError.
StepOutcome run_step(const JobStep& step, const StageContext& context);

/// Throws IoError for a file that a step reads, that no step makes and that is not there.
void require_inputs(const Job& job);

/// name, verb, up_to_date, seconds, peak_memory_bytes, run_started and result of each.
nlohmann::json steps_json(const std::vector<StepOutcome>& outcomes);

/// A line for each step, and the commands that make films of the pictures.
std::string steps_summary(const std::vector<StepOutcome>& outcomes);

}  // namespace slim
