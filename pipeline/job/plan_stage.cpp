#include "pipeline/job/plan_stage.h"

#include "pipeline/build/plan_file.h"
#include "pipeline/child_process.h"
#include "pipeline/job/job.h"
#include "pipeline/job/makefile.h"
#include "pipeline/job/slurm_script.h"
#include "pipeline/job/snakefile.h"
#include "pipeline/memory_size.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

namespace slim {
namespace {

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
/// Of a job's memory: less holds no points (build's --memory is at least that).
constexpr std::uint64_t kLeastMemory = 64 * kMiB;
/// A view holds up to 384 MiB of a picture's bands and what is made of them, whatever [fit] memory
/// is: 608 MiB for 4096x4096 of 100,000 points; with lines 640 MiB, for 16384x16384 780 MiB.
constexpr std::uint64_t kMemoryOfViews = 1024 * kMiB;
/// The script must not depend on the machine that prints it.
constexpr int kThreads = 4;

/// Beside the points a step holds the program, the tree and a margin.
std::uint64_t memory_of_a_job(const PlanConfig& config, const Job& job) {
    if (!config.memory.empty()) return parse_memory_size(config.memory);
    const std::uint64_t points = parse_memory_size(job.stages.memory);
    return std::max(points + points / 4 + 256 * kMiB, kMemoryOfViews);
}

/// For people, who plan a run with it.
std::string memory_text(const Job& job) {
    return fmt::format(
        "Memory: a build holds points of {} (memory in [fit]) at a time; a view's pictures and "
        "drawings are given {}\n",
        memory_size_text(parse_memory_size(job.stages.memory)), memory_size_text(kMemoryOfViews));
}

void check_memory(const PlanConfig& config) {
    if (config.memory.empty()) return;
    if (parse_memory_size(config.memory) < kLeastMemory)
        throw ConfigError(
            {.key = "memory", .expected = "at least 64MiB", .found = "'" + config.memory + "'"});
    if (config.explain)
        throw ConfigError({.key = "memory",
                           .problem = "--explain asks for none",
                           .expected = "--format slurm or snakemake with it"});
    if (config.format == "make" || config.format == "slices")
        throw ConfigError({.key = "memory",
                           .problem = "make asks for none",
                           .expected = "--format slurm or snakemake with it"});
}

/// Options that were given and play no part.
void refuse_without_effect(const PlanConfig& config, int threads_given) {
    if (config.explain && config.format != PlanConfig{}.format)
        throw ConfigError({.key = "format",
                           .problem = "--explain prints none; leave out --format " +
                                      config.format});
    if (threads_given == 0) return;
    if (config.explain)
        throw ConfigError(
            "--threads: --explain asks for none; expected --format slurm or snakemake with it");
    if (config.format == "make" || config.format == "slices")
        throw ConfigError(
            fmt::format("--threads: make asks for none; expected --format slurm or snakemake with "
                        "it, or SLIM_THREADS={} make",
                        threads_given));
}

/// In the form that the config names.
std::string text_of(const PlanConfig& config, int threads_given) {
    const Job job =
        read_job(std::filesystem::absolute(job_file(config.source)), job_settings(config.source));
    const std::filesystem::path programs = program_folder();
    if (config.format == "make") return makefile_of(job, programs);
    if (config.format == "slices") return slice_rules_of(job, read_plan(job.stages.work), programs);
    const ClusterResources resources{threads_given > 0 ? threads_given : kThreads,
                                     memory_of_a_job(config, job)};
    if (config.format == "slurm") return slurm_script_of(job, programs, resources);
    if (config.format == "snakemake") return snakefile_of(job, programs, resources);
    return slurm_slices_of(job, read_plan(job.stages.work), programs, resources);
}

}  // namespace

nlohmann::json run_plan(const PlanConfig& config, StageContext& context) {
    check_memory(config);
    refuse_without_effect(config, context.threads_given);
    const auto read = config.explain ? read_job_to_explain : read_job;
    const Job job = read(job_file(config.source), job_settings(config.source));
    context.text = config.explain ? explanation_of(job) + memory_text(job)
                                  : text_of(config, context.threads_given);
    std::vector<std::string> refused;
    for (const ConfigError& error : job.refused) refused.emplace_back(error.what());
    nlohmann::json steps = nlohmann::json::array();
    for (const JobStep& step : job.steps)
        steps.push_back({{"name", step.name},
                         {"verb", step.verb},
                         {"arguments", step.arguments},
                         {"output", step.output.string()},
                         {"shares", step.shares.size()}});
    return {{"folder", job.folder.string()},
            {"steps", steps},
            {"left_out", job.left_out},
            {"refused", refused},
            {"missing", job.missing},
            {"uncertain", job.uncertain},
            {"text", context.text}};
}

}  // namespace slim
