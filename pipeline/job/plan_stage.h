#pragma once

#include "pipeline/job/job_source.h"
#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <string>

namespace slim {

/// `slim plan JOB [CLOUD...]`.
struct PlanConfig {
    JobSource source;
    std::string format = "make";
    std::string memory;
    bool explain = false;

    template <class V>
    void visit(V&& field) {
        source.visit(field);
        field.choice("format", format,
                     "make: a Makefile; slurm: a script that submits array jobs; snakemake: a "
                     "Snakefile; slices "
                     "and slurm-slices: the part for the slices, once the clouds are sliced (make "
                     "and the script "
                     "call these themselves)",
                     {"make", "slurm", "snakemake", "slices", "slurm-slices"});
        field("memory", memory,
              "of slurm and snakemake: what each job asks for, at least 64MiB, besides --threads "
              "(4 without it, on any machine); without it [fit] memory, a quarter and 256MiB more, "
              "at least 1GiB");
        field("explain", explain,
              "instead, say what is done, what is left out and why, and what will be missing");
    }
};

/// Prints a job in the form that make, Slurm or Snakemake run, or explains it; runs nothing.
nlohmann::json run_plan(const PlanConfig& config, StageContext& context);

}  // namespace slim
