#pragma once

#include "pipeline/job/job.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace slim {

/// What a step of a job came to: its --json object and what it cost (the recorded cost if the
/// output was up to date).
struct StepOutcome {
    JobStep step;
    nlohmann::json result;
    bool up_to_date = false;
    double seconds = 0;
    double peak_memory_bytes = 0;
};

/// A self-contained HTML page: the model's figures, its errors, what each step cost, and the
/// pictures (referenced relative to the job's folder).
std::string index_page(const Job& job, const std::vector<StepOutcome>& outcomes);

}  // namespace slim
