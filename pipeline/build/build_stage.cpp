#include "pipeline/build/build_stage.h"

#include "formats/atomic_file.h"
#include "pipeline/build/build_color.h"
#include "pipeline/build/build_summary.h"
#include "pipeline/build/edges_said.h"
#include "pipeline/build/fit_stage.h"
#include "pipeline/build/normals_stage.h"
#include "pipeline/build/sensors.h"
#include "pipeline/build/slice_stage.h"
#include "pipeline/build/tree_stage.h"
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
    s.face_points = c.face_points;
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
    static_cast<FitOptions&>(f) = c;
    f.memory = c.memory;
    f.seed = c.seed;
    return f;
}

/// What the stages of a build know of each other.
struct BuildState {
    HandedPoints handed;
    std::map<std::string, std::string> written = {};
};

/// Runs one stage with a context of its own; its result, with its seconds, those of all its threads
/// and its peak memory, goes under its name.
template <class Config, class Run>
nlohmann::json run_one(const char* name, const Config& config, Run run, StageContext& parent,
                       BuildState& state, nlohmann::json& stages) {
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
        throw ConfigError(config.output + ": is a folder; --output expects a file to write, as " +
                          (fs::path(config.output) / "model.slim").string());
    check_replaceable(config.output);
    for (const std::string& input : config.inputs) refuse_to_overwrite(config.output, {input});
    refuse_to_replace_other(config.output);
    refuse_other_ending(config.output);
    if (parse_memory_size(config.memory) < kLeastMemory)
        throw ConfigError("--memory " + config.memory + ": expected at least " +
                          memory_size_text(kLeastMemory) + ", which the coarse levels take");
}

/// The work folder of a build that was not given one.
std::string own_work(const BuildConfig& config) { return config.output + ".work"; }

/// Where it goes once nothing in it is needed. A build is killed between its commit and the end of
/// this folder's removal; the next one finds by the name that it is nobody's. A folder of the other
/// name may be one that `slim slice --work` made and make goes on with.
std::string used_up_work(const BuildConfig& config) { return own_work(config) + ".done"; }

void put_aside(const BuildConfig& config) {
    std::error_code error;
    fs::rename(own_work(config), used_up_work(config), error);
    if (error) fs::remove_all(own_work(config));
}

void remove_used_up(const BuildConfig& config) {
    std::error_code ignored;  // another process may be removing it, too
    fs::remove_all(used_up_work(config), ignored);
}

/// The stages, one after the other, and the record of what they came to.
nlohmann::json build_in(const BuildConfig& config, const std::string& work, Stamp& stamp,
                        StageContext& context) {
    nlohmann::json stages = nlohmann::json::object();
    BuildState state{HandedPoints(config.work.empty())};
    const auto run_next = [&](const char* name, const auto& of_stage, auto run) {
        return run_one(name, of_stage, run, context, state, stages);
    };
    run_next("slice", slice_config(config, work), run_slice);
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
    take_recorded_costs(work, stages);
    result.erase("up_to_date");
    result.erase("recorded");
    result["noise_variance"] = fit.at("noise_variance");
    if (fit.contains("typical_variance"))
        result["typical_variance"] = fit.at("typical_variance");
    result["noise"] = noise_over_diagonal(fit.at("noise_variance").get<double>(),
                                          stages.at("slice").at("diagonal").get<double>());
    result["dropped"] = fit.at("dropped_isolated").get<std::uint64_t>() +
                        fit.at("dropped_unexplained").get<std::uint64_t>() +
                        fit.at("dropped_beside").get<std::uint64_t>();
    result["normals_estimated"] = normals.at("estimated");
    result["normals_turned"] = normals.at("turned");
    result.update(sharp_of(fit));
    result["leaf_error_rms"] = leaf_error_rms(config.output);
    result["drawn_diagonal"] = drawn_diagonal(config.output);
    result["stages"] = stages;
    if (config.work.empty()) put_aside(config);
    return stamp.commit(std::move(result));
}

/// Ends with what becomes of the intermediate files of a build that failed or was stopped. Called
/// while `error` is handled.
[[noreturn]] void give_up(const BuildConfig& config, const std::string& work, const Error& error) {
    const bool bad = error.code() == ExitCode::bad_data || error.code() == ExitCode::usage;
    const bool stopped =
        error.code() == ExitCode::interrupted || error.code() == ExitCode::terminated;
    const bool sliced = fs::exists(manifest_path(work, "slice"));
    // A bad input leaves nothing to resume from, a build stopped while slicing hardly more.
    if (config.work.empty() && (bad || (stopped && !sliced))) fs::remove_all(work);
    if (!sliced || !fs::exists(work)) throw;  // as it came, with its own type
    throw Error(error.code(), fmt::format("{}; the same command goes on where it was, from {}",
                                          error.what(), work));
}

}  // namespace

nlohmann::json run_build(const BuildConfig& config, StageContext& context) {
    check_output(config);
    check_fit_config(fit_config(config, ""));
    check_normals_config(normals_config(config, ""));
    const bool keep_work = !config.work.empty();
    const std::string work = keep_work ? config.work : own_work(config);
    if (!keep_work) remove_used_up(config);
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
        try {
            result = build_in(config, work, stamp, context);
            if (!keep_work) remove_used_up(config);
        } catch (const Error& error) {
            give_up(config, work, error);
        }
    }
    context.text = build_summary(config.output, config.inputs, result);
    return result;
}

}  // namespace slim
