#pragma once

#include "pipeline/job_source.h"
#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <string>

namespace slim {

/// `slim plan JOB [CLOUD...]`.
struct PlanConfig {
    JobSource source;
    std::string format = "make";
    bool explain = false;

    template <class V>
    void visit(V&& field) {
        source.visit(field);
        field.choice("format", format,
                     "make: a Makefile; slices: its rules for the slices, once the clouds are sliced (make "
                     "calls this itself)",
                     {"make", "slices"});
        field("explain", explain, "instead, say what is done, what is left out and why");
    }
};

/// Prints a job as a Makefile, or explains it; runs nothing.
nlohmann::json run_plan(const PlanConfig& config, StageContext& context);

}  // namespace slim
