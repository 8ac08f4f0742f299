#include "pipeline/plan_stage.h"

#include "pipeline/child_process.h"
#include "pipeline/job.h"

namespace slim {

nlohmann::json run_plan(const PlanConfig& config, StageContext& context) {
    const Job job = read_job(config.job);
    context.text = config.explain ? explanation_of(job) : makefile_of(job, program_folder());
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
