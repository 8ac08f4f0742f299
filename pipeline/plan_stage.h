#pragma once

#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <string>

namespace slim {

/// `slim plan JOB`.
struct PlanConfig {
    std::string job;
    std::string format = "make";
    bool explain = false;

    template <class V>
    void visit(V&& field) {
        field.input("job", job, "job file (TOML)");
        field.choice("format", format, "what to print", {"make"});
        field("explain", explain, "instead, say what is done, what is left out and why");
    }
};

/// Prints a job as a Makefile, or explains it; runs nothing.
nlohmann::json run_plan(const PlanConfig& config, StageContext& context);

}  // namespace slim
