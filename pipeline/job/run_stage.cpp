#include "pipeline/job/run_stage.h"

#include "formats/atomic_file.h"
#include "pipeline/input_kind.h"
#include "pipeline/job/index_page.h"
#include "pipeline/job/job.h"
#include "pipeline/job/job_config.h"
#include "pipeline/job/job_left_out.h"
#include "pipeline/job/job_steps.h"
#include "pipeline/json_text.h"
#include "pipeline/manifest.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>

namespace slim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Pictures beside the job's that no view of it makes any more: those of manifests that no step
/// writes.
void warn_of_old_pictures(const Job& job, Reporter& reporter) {
    std::set<fs::path> known;
    for (const JobStep& step : job.steps) known.insert(step.target.filename());
    std::vector<std::string> old;
    for (const fs::directory_entry& entry : fs::directory_iterator(job.folder)) {
        const fs::path name = entry.path().filename();
        if (!name.string().ends_with(".done.json") || known.contains(name)) continue;
        std::ifstream in(entry.path());
        const json manifest = json_or_discarded(in);
        if (!manifest.is_object() || manifest.value("stage", "") != "render") continue;
        for (const json& file : manifest.value("outputs", json::array()))
            old.push_back(file.value("path", ""));
    }
    std::sort(old.begin(), old.end());
    if (!old.empty())
        reporter.warn(fmt::format("{}: pictures of no view of this job: {}", job.folder.string(),
                                  fmt::join(old, ", ")));
}

std::string text_of_file(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

std::string resolved_run(const RunConfig& config) {
    if (config.job.empty()) return "";
    if (const fs::path style = style_alone(config); !style.empty()) return text_of_file(style);
    return resolved_job(job_file(config), job_settings(config));
}

json run_job(const RunConfig& config, StageContext& context) {
    const std::vector<std::string> settings = job_settings(config);
    const Job job = read_job(job_file(config), settings);
    require_inputs(job);
    make_writable_folder(job.folder);
    Stamp stamp(context, page_target(job));
    stamp.input(job.file);
    for (const std::string& setting : settings) stamp.depends("--set " + setting);
    std::vector<StepOutcome> outcomes;
    for (const JobStep& step : job.steps) outcomes.push_back(run_step(step, context));
    warn_of_old_pictures(job, context.reporter);
    if (const std::string line = left_out_in_a_line(job.left_out, "slim plan --explain");
        !line.empty())
        context.reporter.info(line);

    json result = {{"folder", job.folder.string()}, {"steps", steps_json(outcomes)},
                   {"left_out", job.left_out}};
    const fs::path index = job.folder / "index.html";
    if (job.html) {
        write_file_atomically(index.string(), index_page(job, outcomes));
        result["index"] = index.string();
        stamp.outputs({index});
    }
    context.text = steps_summary(outcomes) + (job.html ? index : job.folder).string() + "\n";
    return stamp.commit(std::move(result));
}

}  // namespace slim
