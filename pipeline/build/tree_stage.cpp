#include "pipeline/build/tree_stage.h"

#include "formats/fit_file.h"
#include "formats/model_file.h"
#include "pipeline/build/fit_stage.h"
#include "pipeline/folder_lock.h"
#include "pipeline/input_kind.h"
#include "pipeline/json_text.h"
#include "pipeline/manifest.h"
#include "pipeline/memory_size.h"
#include "pipeline/peak_memory.h"
#include "pipeline/version.h"
#include "slim/base/error.h"
#include "slim/slicing/block_plan.h"
#include "slim/tree/drawn_bounds.h"
#include "slim/tree/loose_leaves.h"
#include "slim/tree/stand_ins.h"
#include "slim/tree/tree_builder.h"

#include <fmt/format.h>

#include <filesystem>
#include <vector>

namespace slim {
namespace {

/// The fit files of a job: coarse levels first, then slice by slice.
std::vector<std::filesystem::path> fit_paths(const TreeConfig& config, const SlicePlan& plan) {
    std::vector<std::filesystem::path> paths;
    if (plan.slices.size() > 1) paths.push_back(coarse_fit_path(config.work));
    for (std::size_t i = 0; i < plan.slices.size(); ++i) paths.push_back(fit_path(config.work, i));
    return paths;
}

void check_all_there(const TreeConfig& config, const std::vector<std::filesystem::path>& paths) {
    std::string missing;
    for (const auto& path : paths)
        if (!std::filesystem::exists(manifest_path(path))) missing += " " + path.string();
    if (!missing.empty())
        throw IncompleteError(fmt::format("{}: these fits are missing:{}: run `slim fit {}`",
                                          config.work, missing, config.work));
}

/// What the fits of a job say of themselves, and where their surfels are.
struct Fits {
    nlohmann::json rules;
    nlohmann::json counts = nlohmann::json::array();
    std::vector<FitReader> readers;

    std::size_t n_surfels() const {
        std::size_t n = 0;
        for (const FitReader& fit : readers) n += fit.n_surfels();
        return n;
    }
    void for_each(const SurfelVisit& visit) const {
        for (const FitReader& fit : readers) fit.for_each(visit);
    }
};

/// throws FormatError if a fit does not say its rules and counts
nlohmann::json header_of_fit(const std::filesystem::path& path, const FitReader& fit) {
    auto header = json_or_discarded(fit.header_json());
    const auto says = [&](const char* key) {
        return header.is_object() && header.contains(key) && header.at(key).is_object();
    };
    if (!says("rules") || !says("counts"))
        throw FormatError(fmt::format("{}: chunk header_json: expected rules and counts, found {}",
                                      path.string(), fit.header_json().substr(0, 100)));
    const auto degree = header.at("rules").value("degree", nlohmann::json());
    if (!degree.is_number_integer() || degree < 1 || degree > kMaxDegree)
        throw FormatError(fmt::format("{}: chunk header_json: degree {} is not 1 to {}",
                                      path.string(), text_of(degree), kMaxDegree));
    return header;
}

/// "t_mdl 0.01, not 0.02" for each rule in which the other fit differs.
std::string differences(const nlohmann::json& rules, const nlohmann::json& other) {
    nlohmann::json all = rules;
    all.update(other);
    std::string text;
    for (const auto& [key, unused] : all.items()) {
        const auto here = other.value(key, nlohmann::json("none"));
        const auto there = rules.value(key, nlohmann::json("none"));
        if (here != there)
            text += fmt::format("{}{} {}, not {}", text.empty() ? "" : "; ", key, text_of(here),
                                text_of(there));
    }
    return text;
}

/// throws IncompleteError if two fits were made with different rules
Fits open_fits(const std::string& work, const std::vector<std::filesystem::path>& paths) {
    Fits out;
    for (const auto& path : paths) {
        const FitReader& fit = out.readers.emplace_back(path.string());
        const auto header = header_of_fit(path, fit);
        if (out.rules.is_null()) out.rules = header.at("rules");
        if (header.at("rules") != out.rules)
            throw IncompleteError(fmt::format(
                "{}: fitted with other settings than {}: {}: run `slim fit {}` for all slices, "
                "with the same options",
                path.string(), paths[0].string(), differences(out.rules, header.at("rules")),
                work));
        out.counts.push_back(header.at("counts"));
    }
    return out;
}

/// What became of the points of a cloud of which no surfel is left, and what to do.
void require_leaves(const SlicePlan& plan, const Fits& fits) {
    const auto sum = [&](const char* key) {
        std::uint64_t n = 0;
        for (const nlohmann::json& counts : fits.counts) n += counts.value(key, std::uint64_t{0});
        return n;
    };
    if (sum("leaves") > 0) return;
    std::vector<std::string> names;
    for (const PlanInput& in : plan.inputs) names.push_back(in.path);
    const std::uint64_t isolated = sum("dropped_isolated"),
                        unexplained = sum("dropped_unexplained"), beside = sum("dropped_beside");
    const std::string dropped =
        isolated + unexplained + beside == 0
            ? "none was dropped, but no ball of them holds a surface"
            : fmt::format("dropped were {} with too few neighbours, {} that no surfel explains and "
                          "{} beside a rim",
                          isolated, unexplained, beside);
    const char* remedy =
        unexplained > isolated
            ? "normals that agree with the points: try --normals estimate, or a larger --t-mdl"
            : "a dozen points and more near each other that neither coincide nor lie on one line: "
              "give more points, or take out strays, within whose extent the others are small";
    throw DataError(
        fmt::format("{}: the fit left no surfel of {} points, so there is nothing to build a model "
                    "of: {}. A surface needs {}",
                    fmt::join(names, ", "), plan.n_points, dropped, remedy));
}

/// The tree is of all slices at once, so its memory grows with the model, not with a slice.
void warn_of_memory(const TreeConfig& config, std::size_t n_surfels, Reporter& reporter) {
    const std::uint64_t needed = kProgramBytes + n_surfels * kTreeBytesPerSurfel;
    if (needed <= parse_memory_size(config.memory)) return;
    const std::uint64_t mebibytes = (needed >> 20) + 1;
    reporter.warn(fmt::format("the tree of {} surfels takes up to {} MiB, more than --memory {}: "
                              "--memory {}MiB would do, or a larger --t-mdl",
                              n_surfels, mebibytes, config.memory, mebibytes));
}

ModelHeader header_of(const SlicePlan& plan, const nlohmann::json& rules) {
    ModelHeader h;
    h.degree = rules.at("degree");
    h.origin = plan.origin;
    h.bounds = plan.bounds;
    h.diagonal = plan.diagonal;
    h.noise_variance = rules.at("noise_variance");
    h.mdl_threshold = rules.at("t_mdl");
    h.n_points = plan.n_points;
    h.seed = rules.at("seed");
    return h;
}

/// Counts of all fits, in the model for `slim info`; no times, threads or paths.
nlohmann::json provenance_of(const SlicePlan& plan, const Fits& fits,
                             const TreeCounts& counts) {
    nlohmann::json inputs = nlohmann::json::array();
    for (const PlanInput& in : plan.inputs)
        inputs.push_back({{"format", in.format},
                          {"points", in.n_points},
                          {"dropped_non_finite", in.n_dropped},
                          {"bad_normals", in.n_bad_normals},
                          {"has_normals", in.has_normals}});
    return {{"program", program_version()},
            {"inputs", inputs},
            {"rules", fits.rules},
            {"fits", fits.counts},
            {"orphans", counts.orphans},
            {"childless", counts.childless}};
}

}  // namespace

nlohmann::json run_tree(const TreeConfig& config, StageContext& context) {
    keep_freed_memory(false);
    const FolderLock lock(config.work, FolderLock::Hold::shared);
    const SlicePlan plan = read_plan(config.work);
    const auto paths = fit_paths(config, plan);
    check_all_there(config, paths);
    refuse_to_replace_other(config.output);
    refuse_other_ending(config.output);
    // The model's own is the build's, if there is one: were this one in its place, a make that goes
    // on after a kill between the two would take the build for done.
    Stamp stamp(context, context.handed ? manifest_path(config.work, "tree")
                                        : manifest_path(config.output));
    stamp.input(plan_path(config.work));  // the model's origin, bounds and inputs stand in no fit
    for (const auto& path : paths) stamp.input(path);
    stamp.outputs({config.output});
    if (auto done = stamp.up_to_date()) return *done;

    if (plan.slices.size() > 1) return_freed_memory();
    const Fits fits = open_fits(config.work, paths);
    require_leaves(plan, fits);
    warn_of_memory(config, fits.n_surfels(), context.reporter);
    TreeCounts counts;
    const auto surfels = [&](const SurfelVisit& visit) { fits.for_each(visit); };
    SurfelTreeData data =
        build_tree(surfels, fits.n_surfels(), header_of(plan, fits.rules), counts);
    context.check_stop();
    const LooseCounts loose = mark_loose(data);
    set_drawn_bounds(data);
    context.check_stop();
    const std::uint64_t n_stand_ins = mark_stand_ins(data);
    context.check_stop();
    write_model(config.output, data, text_of(provenance_of(plan, fits, counts)));
    return stamp.commit({{"leaves", data.header.n_leaves},
                         {"nodes", data.nodes.size()},
                         {"orphans", counts.orphans},
                         {"childless", counts.childless},
                         {"pieces", loose.pieces},
                         {"loose", loose.loose()},
                         {"loose_in_noise", loose.in_noise},
                         {"loose_astray", loose.astray},
                         {"stand_ins", n_stand_ins},
                         {"points", plan.n_points},
                         {"bytes", std::filesystem::file_size(config.output)}});
}

}  // namespace slim
