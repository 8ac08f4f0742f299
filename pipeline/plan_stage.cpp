#include "pipeline/plan_stage.h"

#include "pipeline/child_process.h"
#include "pipeline/job.h"
#include "pipeline/makefile.h"
#include "pipeline/plan_file.h"

namespace slim {
namespace {

std::string text_of(const PlanConfig& config) {
    if (config.explain)
        return explanation_of(read_job(job_file(config.source), job_settings(config.source)));
    const Job job =
        read_job(std::filesystem::absolute(job_file(config.source)), job_settings(config.source));
    if (config.format == "make") return makefile_of(job, program_folder());
    return slice_rules_of(job, read_plan(job.stages.work), program_folder());
}

}  // namespace

nlohmann::json run_plan(const PlanConfig& config, StageContext& context) {
    const Job job = read_job(job_file(config.source), job_settings(config.source));
    context.text = text_of(config);
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
