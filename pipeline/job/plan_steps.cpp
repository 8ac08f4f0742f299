#include "pipeline/job/plan_steps.h"

#include <fmt/format.h>

#include <utility>

namespace slim {

namespace fs = std::filesystem;

Words verb_command(const fs::path& programs, const std::string& verb, const Words& arguments) {
    Words words = {(programs / ("slim-" + verb)).string()};
    words.insert(words.end(), arguments.begin(), arguments.end());
    return words;
}

Words job_words(const Job& job) {
    Words words = {job.file.string()};
    for (const std::string& setting : job.settings) words.push_back("--set=" + setting);
    return words;
}

fs::path made_by(const fs::path& file, const Job& job) {
    for (const JobStep& step : job.steps)
        if (step.output == file) return step.target;
    return file;
}

Words joining_build(const JobStep& step, const Job& job, const fs::path& programs) {
    Words words = verb_command(programs, step.verb, step.arguments);
    words.push_back("--work=" + job.stages.work.string());
    return words;
}

PlanTask whole_task(const JobStep& step, const Job& job, const fs::path& programs) {
    PlanTask task{
        verb_command(programs, step.verb, step.arguments), {}, step.target, step.products};
    for (const fs::path& input : step.inputs) task.needs.push_back(made_by(input, job));
    return task;
}

std::vector<PlanTask> share_tasks(const JobStep& step, const Job& job, const fs::path& programs) {
    std::vector<PlanTask> tasks;
    for (const JobShare& share : step.shares) {
        PlanTask task = whole_task(step, job, programs);
        task.command.push_back(share.option);
        task.target = share.target, task.products = share.products;
        tasks.push_back(std::move(task));
    }
    return tasks;
}

PlanTask join_task(const JobStep& step, const Job& job, const fs::path& programs) {
    PlanTask task = whole_task(step, job, programs);
    task.command.push_back(fmt::format("--join={}", step.shares.size()));
    task.needs.clear();
    for (const JobShare& share : step.shares) task.needs.push_back(share.target);
    return task;
}

bool normals_in_order(const Job& job, const SlicePlan& plan) {
    return job.stages.estimate_normals || !plan.has_normals;
}

}  // namespace slim
