#include "pipeline/render/render_views.h"

#include "formats/model_file.h"
#include "pipeline/contains.h"
#include "pipeline/input_kind.h"
#include "pipeline/job/job.h"
#include "pipeline/job/job_source.h"
#include "pipeline/job/job_steps.h"
#include "pipeline/render/render_view.h"
#include "pipeline/signals.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace slim {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// What a build of this model would have been told.
BuildStages stages_of(const std::string& file) {
    require_model(file);
    const ModelFile model = ModelFile::open_by_pages(file);
    BuildStages stages;
    stages.degree = std::to_string(model.header().degree);
    stages.color = !model.colors().empty();
    stages.sharp = model.tree().sharp().empty() ? "off" : "on";
    stages.given = true;
    return stages;
}

/// The options that were given, as a job's tables would say them.
std::vector<TomlValue> options_given(const RenderConfig& config, const StageContext& context) {
    RenderConfig copy = config;
    const FieldList fields = fields_of(copy);
    std::vector<TomlValue> options;
    for (const Field& field : fields.fields()) {
        if (!contains(context.given, field.key)) continue;
        if (field.is_word() || field.role == FieldRole::output || field.key == "job") continue;
        TomlValue option{field.key, field.kind(), field.is_list(), field.items(), kOnCommandLine};
        if (field.is_path())
            for (std::string& path : option.items)
                if (!path.empty()) path = fs::absolute(path).string();
        options.push_back(std::move(option));
    }
    return options;
}

/// A task of a plan draws one view: its own options say so, not the job's.
void refuse_parts(const RenderConfig& config) {
    if (!config.share.empty() || config.join > 0)
        throw ConfigError(fmt::format(
            "{} divides one picture or film, and --job draws all views of a job: expected one of "
            "the two ('slim plan' divides the views of a job among tasks)",
            config.join > 0 ? "--join" : "--share"));
}

Job drawing_of(const RenderConfig& config, const StageContext& context) {
    JobDrawing drawing;
    drawing.model = config.model;
    drawing.options = options_given(config, context);
    if (is_folder_output(config.output)) drawing.folder = fs::path(config.output);
    else drawing.picture = config.output, drawing.folder = drawing.picture.parent_path();
    // The model stands where a style's clouds do.
    const fs::path file = job_file({config.job, {config.model}, "", {}});
    drawing.stages = stages_of(config.model);
    return read_drawing(file, drawing);
}

/// Runs a view; what it fails with says where the job asks for it.
StepOutcome drawn(const JobStep& step, const Job& job, const StageContext& context) {
    try {
        return run_step(step, context);
    } catch (const Interrupted&) {
        throw;
    } catch (const Error& error) {
        throw Error(error.code(), toml_place(job.file, step.line) + ": " + error.what());
    }
}

}  // namespace

Json draw_views(const RenderConfig& config, StageContext& context) {
    refuse_parts(config);
    const Job job = drawing_of(config, context);
    std::vector<StepOutcome> outcomes;
    for (const JobStep& step : job.steps) outcomes.push_back(drawn(step, job, context));
    Json files = Json::array();
    for (const StepOutcome& outcome : outcomes)
        for (const Json& file : outcome.result.value("files", Json::array())) files.push_back(file);
    for (const std::string& reason : job.left_out) context.reporter.info("left out: " + reason);
    context.text = steps_summary(outcomes);
    for (const Json& file : files) context.text += file.get<std::string>() + "\n";
    return {{"files", files},
            {"folder", job.folder.string()},
            {"steps", steps_json(outcomes)},
            {"left_out", job.left_out}};
}

}  // namespace slim
