#include "pipeline/build_stage.h"

#include "pipeline/fit_stage.h"
#include "pipeline/manifest.h"
#include "pipeline/memory_size.h"
#include "pipeline/normals_stage.h"
#include "pipeline/peak_memory.h"
#include "pipeline/sensors.h"
#include "pipeline/slice_stage.h"
#include "pipeline/tree_stage.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>

namespace slim {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kLeastMemory = 64 << 20;

SliceConfig slice_config(const BuildConfig& c, const std::string& work) {
    SliceConfig s;
    s.inputs = c.inputs;
    s.work = work;
    s.memory = c.memory;
    s.slices = c.slices;
    s.strict = c.strict;
    return s;
}

NormalsConfig normals_config(const BuildConfig& c, const std::string& work) {
    NormalsConfig n;
    n.work = work;
    n.slice = kAllSlices;
    n.normals = c.normals;
    n.sensors = c.sensors;
    return n;
}

FitConfig fit_config(const BuildConfig& c, const std::string& work) {
    FitConfig f;
    f.work = work;
    f.slice = kAllSlices;
    f.degree = c.degree;
    f.t_mdl = c.t_mdl;
    f.lambda = c.lambda;
    f.sharp = c.sharp;
    f.memory = c.memory;
    f.seed = c.seed;
    return f;
}

/// Runs one stage with a context of its own; its result, with its seconds and peak memory, goes under
/// its name.
template <class Config, class Run>
nlohmann::json run_one(const char* name, const Config& config, Run run, StageContext& parent,
                       nlohmann::json& stages) {
    StageContext context = for_stage(parent, name, config);
    const PeakMeter peak;
    const auto start = std::chrono::steady_clock::now();
    nlohmann::json result = run(config, context);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    parent.reporter.info(fmt::format("{}: {:.2f} s", name, seconds.count()));
    stages[name] = result;
    stages[name]["seconds"] = seconds.count();
    stages[name]["peak_memory_bytes"] = peak.bytes();
    parent.check_stop();
    return result;
}

/// The output must be a file's name of its own: neither a folder nor one of the clouds.
void check_output(const BuildConfig& config) {
    std::error_code ignored;
    if (fs::is_directory(config.output, ignored))
        throw ConfigError(config.output + ": is a folder; --output expects a file to write, as " +
                          (fs::path(config.output) / "model.slim").string());
    for (const std::string& input : config.inputs)
        if (fs::equivalent(input, config.output, ignored))
            throw ConfigError(config.output + ": is an input cloud; --output would overwrite it");
    if (parse_memory_size(config.memory) < kLeastMemory)
        throw ConfigError("--memory " + config.memory + ": expected at least " +
                          memory_size_text(kLeastMemory) + ", which the coarse levels take");
}

nlohmann::json build_in(const BuildConfig& config, const std::string& work, StageContext& context) {
    const bool keep_work = !config.work.empty();
    Stamp stamp(context, manifest_path(config.output));
    for (const std::string& input : config.inputs) {
        stamp.input(input);
        stamp.optional_input(scans_json_path(input));
    }
    if (!config.sensors.empty()) stamp.input(config.sensors);
    if (auto done = stamp.up_to_date()) return *done;

    nlohmann::json stages = nlohmann::json::object();
    run_one("slice", slice_config(config, work), run_slice, context, stages);
    const auto normals =
        run_one("normals", normals_config(config, work), run_normals, context, stages);
    const auto fit = run_one("fit", fit_config(config, work), run_fit, context, stages);
    TreeConfig tree;
    tree.work = work;
    tree.output = config.output;
    nlohmann::json result = run_one("tree", tree, run_tree, context, stages);
    result.erase("up_to_date");
    result.erase("recorded");
    result["noise_variance"] = fit.at("noise_variance");
    result["dropped"] = fit.at("dropped_isolated").get<std::uint64_t>() +
                        fit.at("dropped_unexplained").get<std::uint64_t>();
    result["normals_estimated"] = normals.at("estimated");
    result["normals_turned"] = normals.at("turned");
    result["stages"] = stages;
    result = stamp.commit({config.output}, result);
    if (!keep_work) fs::remove_all(work);
    return result;
}

}  // namespace

nlohmann::json run_build(const BuildConfig& config, StageContext& context) {
    check_output(config);
    const bool keep_work = !config.work.empty();
    const std::string work = keep_work ? config.work : config.output + ".work";
    try {
        return build_in(config, work, context);
    } catch (const Error& e) {
        // A bad input leaves nothing to resume from.
        if (!keep_work && (e.code() == ExitCode::bad_data || e.code() == ExitCode::usage))
            fs::remove_all(work);
        throw;
    }
}

}  // namespace slim
