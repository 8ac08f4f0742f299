#include "pipeline/build/fit_stage.h"

#include "formats/fit_file.h"
#include "pipeline/build/cover_counts_json.h"
#include "pipeline/build/edges_said.h"
#include "pipeline/build/fit_noise.h"
#include "pipeline/build/fit_rules.h"
#include "pipeline/build/normals_stage.h"
#include "pipeline/build/slice_points.h"
#include "pipeline/folder_lock.h"
#include "pipeline/json_text.h"
#include "pipeline/manifest.h"
#include "pipeline/memory_size.h"
#include "pipeline/peak_memory.h"
#include "slim/base/error.h"
#include "slim/model/distinct_points.h"
#include "slim/model/surfel_tree.h"
#include "slim/slicing/block_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace slim {
namespace {

/// Covers points and writes the surfels as they come: they take no memory, however many. Returns
/// the counts, and sharp_json.
nlohmann::json write_cover(const std::filesystem::path& path, const PointBlock& points,
                           CoverRules rules, StageContext& context) {
    FitWriter file(path.string());
    rules.keep = [&](const FittedSurfel& s) { file.add(s); };
    const Cover cover = cover_points(points, rules, context.reporter);
    context.check_stop();
    nlohmann::json result = counts_json(cover.counts);
    const nlohmann::json sharp = sharp_json(rules, cover);
    rules.sharp = sharp.at("sharp");
    file.commit(text_of({{"rules", rules_json(rules)}, {"counts", result}}), cover.dropped);
    result.update(sharp);
    return result;
}

/// Coarse levels of a job in slices: fitted once, from a random sample of all points.
nlohmann::json fit_coarse(const FitConfig& config, const SlicePlan& plan, const CoverRules& rules,
                          const FitDivision& division, StageContext& context) {
    const auto output = coarse_fit_path(config.work);
    Stamp stamp(context, manifest_path(output));
    for (std::size_t i = 0; i < plan.slices.size(); ++i)
        stamp.input(oriented_points_path(config.work, i));
    stamp.input(plan_path(config.work));
    stamp.depends(shared_values(rules));
    stamp.outputs({output});
    if (auto done = stamp.up_to_date()) return *done;
    PointBlock sample = read_coarse_sample(config.work, plan, division.share, config.seed);
    keep_distinct(sample, [](const Vec3d&) { return false; });
    CoverRules coarse = rules;
    // A gap that waits till the first fine level may ask for a leaf wider than the slices can see.
    coarse.last_level = division.last_coarse;
    if (division.last_coarse == division.first_fine) coarse.provisional = division.halo;
    coarse.share = division.share;
    nlohmann::json result = write_cover(output, sample, coarse, context);
    result["sample"] = sample.size();
    return stamp.commit(std::move(result), Outlasts::process);
}

/// What the fine levels of a slice take over from the coarse ones: leaves whose balls meet it and
/// its halo.
FitFile read_coarse_near(const FitConfig& config, const SlicePlan& plan, std::size_t slice,
                         double halo) {
    const Bbox region = plan.slices[slice].region;
    return read_fit(coarse_fit_path(config.work).string(), [=](const FittedSurfel& s) {
        return (s.flags & kLeaf) != 0 &&
               is_near(region, s.surfel.center, halo + s.surfel.support_radius);
    });
}

nlohmann::json fit_slice(const FitConfig& config, const SlicePlan& plan, CoverRules rules,
                         std::size_t slice, const FitDivision& division, StageContext& context) {
    const auto output = fit_path(config.work, slice);
    const bool sliced = plan.slices.size() > 1;
    std::optional<PointBlock> handed;
    if (context.handed)
        handed = context.handed->take(oriented_points_path(config.work, slice).string());
    const bool in_memory = handed && !context.writes_handed_points();
    Stamp stamp(context, manifest_path(output));
    stamp.input(plan_path(config.work));
    if (!in_memory)
        for (const std::size_t i : slices_near(plan, slice, division.halo))
            stamp.input(oriented_points_path(config.work, i));
    if (sliced) stamp.input(coarse_fit_path(config.work));
    stamp.depends(shared_values(rules));
    stamp.outputs({output});
    if (!in_memory)
        if (auto done = stamp.up_to_date()) return *done;
    FitFile coarse;
    if (sliced) {
        coarse = read_coarse_near(config, plan, slice, division.halo);
        rules.rungs_above = kHaloRungs;
        rules.owns = [region = plan.slices[slice].region](const Vec3d& p) {
            return is_in(region, p);
        };
    }
    rules.first_level = division.first_fine;
    rules.done = source_of(coarse.surfels);
    rules.dropped = coarse.dropped;
    PointBlock block =
        handed ? std::move(*handed) : read_with_halo(config.work, plan, slice, division.halo);
    const std::uint64_t copies =
        keep_distinct(block, [&](const Vec3d& p) { return !rules.owns || rules.owns(p); });
    nlohmann::json result = write_cover(output, block, rules, context);
    result["copies"] = copies;
    return stamp.commit(std::move(result), Outlasts::process);
}

Remedies remedies() {
    return runs_in_a_job() ? Remedies::of_a_job : Remedies::of_a_command;
}

/// What a result says of sharp surfels; the summary of a build says it itself, but in a job, which
/// has none.
void say_sharp(const nlohmann::json& result, const StageContext& context) {
    const bool is_said_later = context.written && !runs_in_a_job();
    if (const std::string text = edges_text(result, remedies()); !text.empty() && !is_said_later)
        context.reporter.info(text);
}

/// For the whole job and its reader.
void take_sharp(const nlohmann::json& one, nlohmann::json& sum, const StageContext& context) {
    sum.update(sharp_of(one));
    say_sharp(one, context);
}

/// Two sheets closer to each other than their points tell apart become one, half-way, where no
/// normals say which point is whose.
void warn_of_merged_sheets(const GlobalNoise& noise, const nlohmann::json& sum,
                           Reporter& reporter) {
    // of the leaves; clouds of one sheet have up to 0.0006 (slim/cover/notes/0017)
    constexpr double least_share = 0.01, least_leaves = 5;
    const double n = sum.value("two_layers", 0.0), leaves = sum.value("leaves", 0.0);
    if (!noise.are_estimated || n < std::max(least_leaves, least_share * leaves)) return;
    reporter.warn(fmt::format(
        "{:.0f} % of the surfels run between two layers of points: two sheets so close to each "
        "other become one half-way between them; only normals of the cloud's own keep them "
        "apart",
        100 * n / leaves));
}

/// What a usual slice of several takes.
std::uint64_t bytes_in_use(const SlicePlan& plan) {
    return plan.n_points / plan.slices.size() * kBytesPerPoint;
}

}  // namespace

std::filesystem::path fit_path(const std::filesystem::path& work, std::size_t slice) {
    return slice_folder(work, slice) / "surfels.fit";
}

std::filesystem::path coarse_fit_path(const std::filesystem::path& work) {
    return work / "coarse.fit";
}

nlohmann::json run_fit(const FitConfig& config, StageContext& context) {
    check_fit_config(config);
    const FolderLock lock(config.work, FolderLock::Hold::shared);
    const SlicePlan plan = read_plan(config.work);
    if (plan.slices.size() > 1)
        keep_freed_memory_of_balls(bytes_in_use(plan));
    else
        keep_freed_memory(true);
    if (plan.n_points < 3 || !(plan.diagonal > 0))
        throw DataError(fmt::format(
            "{}: {} within a box of diagonal {}: a surface needs at least 3 points that do not "
            "coincide",
            plan.inputs.empty() ? config.work : plan.inputs[0].path,
            plan.n_points == 1 ? "1 point" : fmt::format("{} points", plan.n_points),
            plan.diagonal));
    const GlobalNoise noise = read_global_noise(config.work, config.lambda, plan);
    CoverRules rules = fit_rules(config, config.seed, plan, noise);
    const FitDivision division = divide_fit(plan, parse_memory_size(config.memory));
    nlohmann::json sum = nlohmann::json::object();
    bool up_to_date = true;
    if (plan.slices.size() > 1) {
        return_freed_memory();
        const auto coarse = fit_coarse(config, plan, rules, division, context);
        add_counts(coarse, sum);
        take_sharp(coarse, sum, context);
        rules.sharp = coarse.at("sharp");  // for all slices
        rules.ask_for_edges = false;
        up_to_date &= coarse.contains("up_to_date");
    }
    const auto todo = config.coarse ? std::vector<std::size_t>{} : slices_to_do(config, plan);
    FreedBetweenSlices freed(parse_memory_size(config.memory), bytes_in_use(plan));
    for (const std::size_t slice : todo) {
        if (plan.slices.size() > 1) freed.begin_next();
        const auto one = fit_slice(config, plan, rules, slice, division, context);
        add_counts(one, sum);
        if (plan.slices.size() == 1) take_sharp(one, sum, context);
        up_to_date &= one.contains("up_to_date");
    }
    if (is_sharp_by_faces(config, plan)) {
        sum["sharp_by_faces"] = true;
        say_sharp(sum, context);
    }
    if (!up_to_date) warn_of_merged_sheets(noise, sum, context.reporter);
    sum["noise_variance"] = noise.noise_variance;
    if (!(config.lambda > 0)) sum["typical_variance"] = noise.typical_variance;
    sum["step_variance"] = noise.step_variance;
    sum["noise_variance_floored"] = noise.floored;
    sum["contrary_share"] = noise.contrary_share;
    sum["follow_normals"] = rules.follow_normals;
    if (up_to_date) sum["up_to_date"] = true;
    return sum;
}

}  // namespace slim
