#pragma once

#include "pipeline/job/job_steps.h"

#include <string>
#include <vector>

namespace slim {

/// A self-contained HTML page: the model's figures, its errors, what each step cost, and the
/// pictures (referenced relative to the job's folder).
std::string index_page(const Job& job, const std::vector<StepOutcome>& outcomes);

}  // namespace slim
