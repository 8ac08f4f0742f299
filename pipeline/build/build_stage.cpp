#include "pipeline/build/build_stage.h"

#include "formats/atomic_file.h"
#include "pipeline/build/build_checks.h"
#include "pipeline/build/build_color.h"
#include "pipeline/build/build_summary.h"
#include "pipeline/build/edges_said.h"
#include "pipeline/build/fit_stage.h"
#include "pipeline/build/normals_stage.h"
#include "pipeline/build/sensors.h"
#include "pipeline/build/slice_stage.h"
#include "pipeline/build/tree_stage.h"
#include "pipeline/build/work_folder.h"
#include "pipeline/folder_lock.h"
#include "pipeline/input_kind.h"
#include "pipeline/json_text.h"
#include "pipeline/manifest.h"
#include "pipeline/memory_size.h"
#include "pipeline/noise_over_diagonal.h"
#include "pipeline/peak_memory.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <new>

namespace slim {
namespace {

namespace fs = std::filesystem;

SliceConfig slice_config(const BuildConfig& c, const std::string& work) {
    SliceConfig s;
    s.inputs = c.inputs;
    s.work = work;
    s.memory = c.memory;
    s.slices = c.slices;
    s.strict = c.strict;
    s.face_points = c.face_points;
    return s;
}

/// What the stages of a build know of each other.
struct BuildState {
    HandedPoints handed;
    WorkFolder work;
    std::map<std::string, std::string> written = {};
    nlohmann::json stages = nlohmann::json::object();  ///< results of those that ended
    bool recording = false;  ///< the model is done, and no input can be bad any more
};

/// What a stage that ran out of memory was asked for.
std::string out_of_memory(const char* stage, const BuildConfig& config) {
    return fmt::format("out of memory in the {} stage of {}{}: a smaller --memory than {} has it "
                       "cut into smaller slices",
                       stage, config.inputs[0],
                       config.inputs.size() > 1
                           ? fmt::format(" and {} more", config.inputs.size() - 1)
                           : "",
                       config.memory);
}

/// Runs one stage with a context of its own; its result, with its seconds, those of all its threads
/// and its peak memory, goes under its name.
template <class Config, class Run>
nlohmann::json run_one(const char* name, const Config& config, Run run, StageContext& parent,
                       BuildState& state) {
    StageContext context = for_stage(parent, name, config);
    context.written = &state.written;
    context.handed = &state.handed;
    const PeakMeter peak;
    const auto start = std::chrono::steady_clock::now();
    const std::clock_t processor_start = std::clock();
    nlohmann::json result = run(config, context);
    const double processor_seconds =
        static_cast<double>(std::clock() - processor_start) / CLOCKS_PER_SEC;
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    parent.reporter.info(fmt::format("{}: {:.2f} s", name, seconds.count()));
    nlohmann::json& stages = state.stages;
    stages[name] = result;
    stages[name]["seconds"] = seconds.count();
    stages[name]["processor_seconds"] = processor_seconds;
    stages[name]["peak_memory_bytes"] = peak.bytes();
    parent.check_stop();
    return result;
}

/// What a stage cost that was found up to date: as the manifests of its parts recorded it.
void take_recorded_cost(const std::vector<fs::path>& manifests, nlohmann::json& stage) {
    if (!stage.contains("up_to_date")) return;
    double seconds = 0, bytes = 0;
    for (const fs::path& path : manifests) {
        std::ifstream file(path);
        const auto manifest = json_or_discarded(file);
        if (!manifest.is_object()) continue;
        seconds += manifest.value("seconds", 0.0);
        bytes = std::max(bytes, manifest.value("peak_memory_bytes", 0.0));
    }
    stage["seconds"] = seconds;
    stage["peak_memory_bytes"] = static_cast<std::uint64_t>(bytes);
}

void take_recorded_costs(const std::string& work, nlohmann::json& stages) {
    const SlicePlan plan = read_plan(work);
    std::vector<fs::path> normals, fits;
    if (plan.slices.size() > 1) fits.push_back(manifest_path(coarse_fit_path(work)));
    for (std::size_t i = 0; i < plan.slices.size(); ++i) {
        normals.push_back(manifest_path(oriented_points_path(work, i)));
        fits.push_back(manifest_path(fit_path(work, i)));
    }
    take_recorded_cost({manifest_path(work, "slice")}, stages["slice"]);
    take_recorded_cost(normals, stages["normals"]);
    take_recorded_cost(fits, stages["fit"]);
}

/// The output must be a file's name of its own: neither a folder nor one of the clouds.
void check_output(const BuildConfig& config) {
    std::error_code ignored;
    if (fs::is_directory(config.output, ignored))
        throw ConfigError({.file = config.output,
                           .problem = "is a folder",
                           .expected = "a file to write, as " +
                                       (fs::path(config.output) / "model.slim").string()});
    check_replaceable(config.output);
    check_replaceable(manifest_path(config.output).string());
    for (const std::string& input : config.inputs) refuse_to_overwrite(config.output, {input});
    refuse_to_replace_other(config.output);
    refuse_other_ending(config.output);
}

/// The work folder of a build that was not given one.
std::string own_work(const BuildConfig& config) { return config.output + ".work"; }

/// Locked by the caller.
WorkFolder claim_work(const BuildConfig& config, Reporter& reporter) {
    if (!config.work.empty()) {
        unmark_work(config.work);
        return {config.work};
    }
    WorkFolder work = claim_own_work(own_work(config));
    if (!work.is_own)
        reporter.info(work.path + ": was sliced by itself, so it is used and kept");
    return work;
}

/// The stages, one after the other, and the record of what they came to.
nlohmann::json build_in(const BuildConfig& config, BuildState& state, Stamp& stamp,
                        StageContext& context) {
    const std::string& work = state.work.path;
    const auto run_next = [&](const char* name, const auto& of_stage, auto run) {
        try {
            return run_one(name, of_stage, run, context, state);
        } catch (const std::bad_alloc&) {
            throw ResourceError(out_of_memory(name, config));
        }
    };
    run_next("slice", slice_config(config, work), run_slice);
    for (const std::string& input : config.inputs)
        if (const auto known = state.written.find(input); known != state.written.end())
            stamp.know_hash(input, known->second);
    const auto normals = run_next("normals", normals_config(config, work), run_normals);
    const auto fit = run_next("fit", fit_config(config, work), run_fit);
    TreeConfig tree;
    tree.work = work;
    tree.output = config.output;
    tree.memory = config.memory;
    nlohmann::json result = run_next("tree", tree, run_tree);
    if (config.color) {
        result["color"] = add_colors(config.output, config.inputs, context);
        result["bytes"] = fs::file_size(config.output);
    }
    nlohmann::json& stages = state.stages;
    take_recorded_costs(work, stages);
    result.erase("up_to_date");
    result.erase("recorded");
    result["noise_variance"] = fit.at("noise_variance");
    if (fit.contains("typical_variance"))
        result["typical_variance"] = fit.at("typical_variance");
    result["noise"] = noise_over_diagonal(fit.at("noise_variance").get<double>(),
                                          stages.at("slice").at("diagonal").get<double>());
    result["dropped"] = stages.at("slice").at("dropped");
    for (const char* cause : {"dropped_isolated", "dropped_unexplained", "dropped_beside"})
        result[cause] = fit.at(cause);
    result["normals_estimated"] = normals.at("estimated");
    result["normals_turned"] = normals.at("turned");
    result.update(sharp_of(fit));
    result["leaf_error_rms"] = leaf_error_rms(config.output);
    result["drawn_diagonal"] = drawn_diagonal(config.output);
    result["stages"] = stages;
    state.recording = true;
    if (state.work.is_own && !put_aside(state.work))
        context.reporter.warn(work + ": holds files that no build made, which are left there");
    try {
        return stamp.commit(std::move(result));
    } catch (...) {  // no record, no finished build: the same command is to go on from the folder
        if (state.work.is_own) bring_back(state.work);
        throw;
    }
}

/// Ends with what becomes of the intermediate files of a build that failed or was stopped. Called
/// while `error` is handled.
[[noreturn]] void give_up(const BuildState& state, const Error& error) {
    const WorkFolder& work = state.work;
    const bool bad = !state.recording && (error.code() == ExitCode::bad_data ||
                                          error.code() == ExitCode::usage);
    const bool sliced = fs::exists(manifest_path(work.path, "slice"));
    const auto slice = state.stages.find("slice");
    const bool sliced_anew = slice != state.stages.end() && !slice->contains("up_to_date");
    const bool wrote = !work.had_plan || sliced_anew || !fs::exists(plan_path(work.path));
    // A bad input leaves nothing to resume from, a build stopped while slicing hardly more. What an
    // earlier build left stays where this one changed none of it.
    const bool goes = work.is_own && ((bad && wrote) || !sliced);
    if (goes) remove_own_work(work);
    if (goes || bad || !sliced) throw;  // as it came, with its own type
    throw Error(error.code(),
                fmt::format("{}; the same command goes on where it was, from {}, which stays",
                            error.what(), work.path));
}

/// The same for what is no Error (a file system's, of memory, of threads): goes on as it came.
void drop_unsliced(const BuildState& state) {
    std::error_code none;
    const bool sliced = fs::exists(manifest_path(state.work.path, "slice"), none);
    if (state.work.is_own && !sliced) remove_own_work(state.work);
}

}  // namespace

nlohmann::json run_build(const BuildConfig& config, StageContext& context) {
    check_output(config);
    check_build_options(config);
    const bool keep_work = !config.work.empty();
    const std::string work = keep_work ? config.work : own_work(config);
    if (!keep_work) remove_put_aside(work);
    Stamp stamp(context, manifest_path(config.output));
    for (const std::string& input : config.inputs) {
        stamp.input(input);
        stamp.optional_input(scans_json_path(input));
    }
    if (!config.sensors.empty()) stamp.input(config.sensors);
    stamp.outputs({config.output});
    // of the folder, which is to be there afterwards
    if (keep_work) stamp.outputs({plan_path(work)});
    nlohmann::json result;
    if (auto done = stamp.up_to_date()) {
        result = *done;
    } else {
        if (config.color) require_colors(config.inputs);
        const FolderLock lock(work);
        const WorkFolder folder = claim_work(config, context.reporter);
        BuildState state{HandedPoints(folder.is_own), folder};
        try {
            result = build_in(config, state, stamp, context);
            if (folder.is_own) remove_put_aside(work);
        } catch (const Error& error) {
            give_up(state, error);
        } catch (const std::exception&) {
            drop_unsliced(state);
            throw;
        }
    }
    context.text = build_summary(config.output, config.inputs, result);
    return result;
}

}  // namespace slim
