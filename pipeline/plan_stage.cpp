#include "pipeline/plan_stage.h"

#include "pipeline/child_process.h"
#include "pipeline/job.h"
#include "pipeline/makefile.h"
#include "pipeline/memory_size.h"
#include "pipeline/plan_file.h"
#include "pipeline/slurm_script.h"
#include "pipeline/snakefile.h"
#include "slim/base/error.h"

#include <cstdint>

namespace slim {
namespace {

/// Beside the points a step holds the program, the tree and a margin.
std::uint64_t memory_of_a_job(const PlanConfig& config, const Job& job) {
    if (!config.memory.empty()) return parse_memory_size(config.memory);
    const std::uint64_t points = parse_memory_size(job.stages.memory);
    return points + points / 4 + (std::uint64_t{256} << 20);
}

std::string text_of(const PlanConfig& config, int threads) {
    if (config.explain)
        return explanation_of(read_job(job_file(config.source), job_settings(config.source)));
    const bool for_make = config.format == "make" || config.format == "slices";
    if (for_make && !config.memory.empty())
        throw ConfigError(
            "--memory: make asks for no memory; expected --format slurm or snakemake with it");
    const Job job =
        read_job(std::filesystem::absolute(job_file(config.source)), job_settings(config.source));
    const std::filesystem::path programs = program_folder();
    if (config.format == "make") return makefile_of(job, programs);
    if (config.format == "slices") return slice_rules_of(job, read_plan(job.stages.work), programs);
    const ClusterResources resources{threads, memory_of_a_job(config, job)};
    if (config.format == "slurm") return slurm_script_of(job, programs, resources);
    if (config.format == "snakemake") return snakefile_of(job, programs, resources);
    return slurm_slices_of(job, read_plan(job.stages.work), programs, resources);
}

}  // namespace

nlohmann::json run_plan(const PlanConfig& config, StageContext& context) {
    const Job job = read_job(job_file(config.source), job_settings(config.source));
    context.text = text_of(config, context.threads);
    nlohmann::json steps = nlohmann::json::array();
    for (const JobStep& step : job.steps)
        steps.push_back({{"name", step.name},
                         {"verb", step.verb},
                         {"arguments", step.arguments},
                         {"output", step.output.string()}});
    return {{"folder", job.folder.string()},
            {"steps", steps},
            {"left_out", job.left_out},
            {"text", context.text}};
}

}  // namespace slim
