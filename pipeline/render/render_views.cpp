#include "pipeline/render/render_views.h"

#include "formats/model_file.h"
#include "pipeline/contains.h"
#include "pipeline/input_kind.h"
#include "pipeline/job/job.h"
#include "pipeline/job/job_left_out.h"
#include "pipeline/job/job_source.h"
#include "pipeline/job/job_steps.h"
#include "pipeline/render/render_inputs.h"
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

/// Said here, of what was given: a view only knows its own picture's name.
void check_output(const RenderConfig& config) {
    const fs::path output = config.output;
    check_folder(is_folder_output(config.output) ? output : output.parent_path(), config.output);
}

/// Whether a fault is of a file: readers of formats say so in their texts.
bool is_of_file(const Fault& fault, const std::string& path) {
    if (path.empty()) return false;
    const std::string whole = fs::absolute(path).string();
    const auto begins_with = [&](const std::string& file) {
        return fault.problem.starts_with(file) &&
               fault.problem.find_first_of(": ", file.size()) == file.size();
    };
    if (!fault.file.empty()) return fs::absolute(fault.file).string() == whole;
    return begins_with(path) || begins_with(whole);
}

/// Whether an option that was given, or its file, is at fault.
bool is_of_given(const Fault& fault, const RenderConfig& config, const StageContext& context) {
    RenderConfig copy = config;
    const FieldList fields = fields_of(copy);
    for (const Field& field : fields.fields()) {
        if (!contains(context.given, field.key) || field.is_word()) continue;
        if (fault.key == field.key) return true;
        if (!field.is_path()) continue;
        for (const std::string& path : field.items())
            if (is_of_file(fault, path)) return true;
    }
    return false;
}

/// Runs a view; what it fails with says where the job asks for it, or which option does.
StepOutcome drawn(const JobStep& step, const Job& job, const RenderConfig& config,
                  const StageContext& context) {
    const std::string place = toml_place(job.file, step.line);
    try {
        return run_step(step, context);
    } catch (const Interrupted&) {
        throw;
    } catch (const StepError& error) {
        Fault fault = error.parts;
        fault.problem = error.reason;
        if (!is_of_given(fault, config, context))
            throw ToldError(error.code(), place + ": " + error.what(), error.parts);
        throw ToldError(error.code(), fmt::format("{} ({}, {})", error.reason, step.name, place),
                        error.parts);
    } catch (const Error& error) {
        throw Error(error.code(), place + ": " + error.what());
    }
}

/// What reading the job says without its place if that is the command line, or a table that an
/// option has changed: the option's name then begins it.
ConfigError of_option(const ConfigError& error, const fs::path& file, const RenderConfig& config,
                      const StageContext& context) {
    Fault fault = error.fault();
    const bool said_here = !fault.said_by.empty();
    const bool is_changed = said_here || is_of_given({.key = fault.key}, config, context);
    if (fault.file != file.string() || !is_changed) return error;
    const std::string place = toml_place(file, fault.line);
    if (!said_here) fault.hint += (fault.hint.empty() ? "" : "; ") + place;
    fault.file.clear(), fault.said_by.clear(), fault.line = 0;
    return ConfigError(fault);
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
    try {
        return read_drawing(file, drawing);
    } catch (const ConfigError& error) {
        throw of_option(error, file, config, context);
    }
}

}  // namespace

Json draw_views(const RenderConfig& config, StageContext& context) {
    refuse_parts(config);
    check_output(config);
    const Job job = drawing_of(config, context);
    std::vector<StepOutcome> outcomes;
    for (const JobStep& step : job.steps) outcomes.push_back(drawn(step, job, config, context));
    Json files = Json::array();
    for (const StepOutcome& outcome : outcomes)
        for (const Json& file : outcome.result.value("files", Json::array())) files.push_back(file);
    if (const std::string line = left_out_in_a_line(job.left_out, "--json"); !line.empty())
        context.reporter.info(line);
    context.text = steps_summary(outcomes);
    for (const Json& file : files) context.text += file.get<std::string>() + "\n";
    return {{"files", files},
            {"folder", job.folder.string()},
            {"steps", steps_json(outcomes)},
            {"left_out", job.left_out}};
}

}  // namespace slim
