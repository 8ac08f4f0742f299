#include "pipeline/render/render_views.h"

#include "formats/model_file.h"
#include "pipeline/contains.h"
#include "pipeline/input_kind.h"
#include "pipeline/job/job.h"
#include "pipeline/job/job_source.h"
#include "pipeline/job/job_steps.h"
#include "pipeline/render/render_inputs.h"
#include "pipeline/render/render_view.h"
#include "pipeline/signals.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string_view>

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

/// Whether a message begins with an option that was given, or with its key or file.
bool is_of_given(const std::string& message, const RenderConfig& config,
                 const StageContext& context) {
    RenderConfig copy = config;
    const FieldList fields = fields_of(copy);
    const auto begins_with = [&](const std::string& word) {
        return message.starts_with(word) &&
               message.find_first_of(": ", word.size()) == word.size();
    };
    for (const Field& field : fields.fields()) {
        if (!contains(context.given, field.key) || field.is_word()) continue;
        if (begins_with(field.option()) || begins_with(field.key)) return true;
        if (!field.is_path()) continue;
        for (const std::string& path : field.items())
            if (!path.empty() && (begins_with(path) || begins_with(fs::absolute(path).string())))
                return true;
    }
    return false;
}

/// Runs a view; what it fails with says where the job asks for it, or which option does.
StepOutcome drawn(const JobStep& step, const Job& job, const RenderConfig& config,
                  const StageContext& context) {
    try {
        return run_step(step, context);
    } catch (const Interrupted&) {
        throw;
    } catch (const Error& error) {
        const std::string what = error.what(), name = step.name + ": ";
        const std::string reason = what.starts_with(name) ? what.substr(name.size()) : what;
        const std::string place = toml_place(job.file, step.line);
        if (!is_of_given(reason, config, context)) throw Error(error.code(), place + ": " + what);
        throw Error(error.code(), fmt::format("{} ({}, {})", reason, step.name, place));
    }
}

/// What reading the job says without its place if that is the command line, or a table that an
/// option has changed: the option's name then begins it.
std::string of_option(const std::string& what, const fs::path& file, const RenderConfig& config,
                      const StageContext& context) {
    constexpr std::string_view kIdle = "no view takes it: ";
    const std::string said_there = toml_place(file, kOnCommandLine) + ": ";
    if (what.starts_with(said_there)) {
        const std::string said = what.substr(said_there.size());
        if (!said.starts_with(kIdle)) return said;
        return fmt::format("{} (no view of {} takes it)", said.substr(kIdle.size()), file.string());
    }
    const std::size_t line = file.string().size() + 1, end = what.find(": ", line);
    if (!what.starts_with(file.string() + ":") || end == std::string::npos || what[line] == ' ')
        return what;
    const std::string said = what.substr(end + 2);
    return is_of_given(said, config, context)
               ? fmt::format("{} ({})", said, what.substr(0, end))
               : what;
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
        throw ConfigError(of_option(error.what(), file, config, context));
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
    for (const std::string& reason : job.left_out) context.reporter.info("left out: " + reason);
    context.text = steps_summary(outcomes);
    for (const Json& file : files) context.text += file.get<std::string>() + "\n";
    return {{"files", files},
            {"folder", job.folder.string()},
            {"steps", steps_json(outcomes)},
            {"left_out", job.left_out}};
}

}  // namespace slim
