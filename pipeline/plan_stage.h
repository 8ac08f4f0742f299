#pragma once

#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace slim {

/// `slim plan JOB`.
struct PlanConfig {
    std::string job;
    std::vector<std::string> settings;  ///< --set TABLE.KEY=VALUE
    std::string format = "make";
    bool explain = false;

    template <class V>
    void visit(V&& field) {
        field.input("job", job, "job file (TOML)");
        field.settings(settings);
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
