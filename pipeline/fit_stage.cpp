#include "pipeline/fit_stage.h"

#include "formats/fit_file.h"
#include "pipeline/folder_lock.h"
#include "pipeline/json_text.h"
#include "pipeline/manifest.h"
#include "pipeline/memory_size.h"
#include "pipeline/normals_stage.h"
#include "pipeline/peak_memory.h"
#include "pipeline/slice_points.h"
#include "slim/base/error.h"
#include "slim/cover/level_cover.h"
#include "slim/fit/noise_variance.h"
#include "slim/fit/normal_variance.h"
#include "slim/model/distinct_points.h"
#include "slim/model/surfel_tree.h"
#include "slim/slicing/block_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>

namespace slim {
namespace {

// of the normals: estimated ones tell nothing new of the points
constexpr double kFewEstimated = 0.01;
// sqrt(lambda) over the spacing between which leaves are fitted again (slim/cover/notes/0010):
// below it the surface is smooth at the points' distance, above it their noise is the larger part
// of what a leaf errs.
constexpr double kSmooth = 0.03, kNoisy = 0.12;

nlohmann::json counts_json(const CoverCounts& c) {
    nlohmann::json fallbacks, degrees;
    for (std::size_t i = 1; i < kFallbacks; ++i)
        fallbacks[fallback_name(static_cast<Fallback>(i))] = c.fallbacks[i];
    for (std::size_t d = 0; d < c.degrees.size(); ++d)
        degrees[std::to_string(d)] = c.degrees[d];
    return {{"leaves", c.leaves},
            {"internals", c.internals},
            {"levels", c.levels},
            {"saturated", c.saturated},
            {"forced", c.forced},
            {"contrary", c.contrary},
            {"normals_disagree", c.normals_disagree},
            {"refitted", c.refitted},
            {"own", c.own},
            {"recentred", c.recentred},
            {"sharp_edges", c.sharp_edges},
            {"sharp_corners", c.sharp_corners},
            {"sharp_rungs", c.sharp_rungs},
            {"dropped_unexplained", c.unexplained},
            {"dropped_isolated", c.isolated},
            {"dropped_beside", c.beside},
            {"searches", c.evaluated},
            {"searches_discarded", c.discarded},
            {"rungs", c.rungs},
            {"refinements", c.refinements},
            {"point_visits", c.point_visits},
            {"fallbacks", fallbacks},
            {"degrees", degrees}};
}

CoverRules rules_of(const FitConfig& config, const SlicePlan& plan, const GlobalNoise& noise) {
    CoverRules rules;
    rules.ladder.choose_degree = config.degree == "auto";
    rules.degree = rules.ladder.choose_degree ? kMaxDegree : config.degree[0] - '0';
    rules.mdl_threshold = config.t_mdl;
    rules.diagonal = plan.diagonal;
    rules.noise_variance = noise.noise_variance;
    rules.least_radius = std::max(2 * plan.coordinate_quantum,
                                  plan.diagonal * std::numeric_limits<double>::epsilon());
    rules.seed = config.seed;
    rules.windows = config.radius_rule == "windows";
    rules.weight = config.weight == "gauss" ? FitWeight::gauss : FitWeight::polynomial;
    rules.reading = static_cast<CoverReading>(config.cover[0] - 'A');
    rules.sharp = config.sharp == "on";
    rules.ladder.contrary_share = noise.contrary_share;
    rules.spacing = noise.spacing;
    rules.typical_variance = noise.typical_variance;
    rules.follow_normals = noise.normals_inform && !rules.windows;
    const double roughness = std::sqrt(noise.noise_variance) / noise.spacing;
    rules.refits = !rules.follow_normals && !rules.windows && rules.weight == FitWeight::gauss &&
                   roughness > kSmooth && roughness < kNoisy;
    return rules;
}

/// What a tree needs to know of a fit, and what all fits of a job must share.
nlohmann::json rules_json(const CoverRules& rules) {
    return {{"degree", rules.degree},
            {"choose_degree", rules.ladder.choose_degree},
            {"t_mdl", rules.mdl_threshold},
            {"diagonal", rules.diagonal},
            {"noise_variance", rules.noise_variance},
            {"contrary_share", rules.ladder.contrary_share},
            {"spacing", rules.spacing},
            {"radius_rule", rules.windows ? "windows" : "ladder"},
            {"weight", rules.weight == FitWeight::gauss ? "gauss" : "polynomial"},
            {"cover", std::string(1, static_cast<char>('A' + static_cast<int>(rules.reading)))},
            {"sharp", rules.sharp},
            {"follow_normals", rules.follow_normals},
            {"refits", rules.refits},
            {"seed", rules.seed}};
}

/// What a fit takes from the normals of all slices, for its manifest.
std::string shared_values(const CoverRules& rules) {
    return fmt::format("lambda {} contrary {} spacing {} typical {} normals {}",
                       rules.noise_variance, rules.ladder.contrary_share, rules.spacing,
                       rules.typical_variance, rules.follow_normals);
}

/// Covers points and writes the surfels as they come: they take no memory, however many.
CoverCounts write_cover(const std::filesystem::path& path, const PointBlock& points,
                        CoverRules rules, StageContext& context) {
    FitWriter file(path.string());
    rules.keep = [&](const FittedSurfel& s) { file.add(s); };
    const Cover cover = cover_points(points, rules, context.reporter);
    context.check_stop();
    file.commit(
        text_of({{"rules", rules_json(rules)}, {"counts", counts_json(cover.counts)}}),
        cover.dropped);
    return cover.counts;
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
    nlohmann::json result = counts_json(write_cover(output, sample, coarse, context));
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
    nlohmann::json result = counts_json(write_cover(output, block, rules, context));
    result["copies"] = copies;
    return stamp.commit(std::move(result), Outlasts::process);
}

/// Adds a slice's sums, one for each number of neighbours; values stay means over all samples so
/// far. A slice that needed fewer neighbours than others stays as it is at its last: flat.
void add_noise(const nlohmann::json& slice, std::vector<NoiseVariance>& sums) {
    if (slice.empty()) return;
    if (sums.size() < slice.size())
        sums.resize(slice.size(), sums.empty() ? NoiseVariance{} : sums.back());
    for (std::size_t i = 0; i < sums.size(); ++i) {
        NoiseVariance& s = sums[i];
        const nlohmann::json& one = slice[std::min(i, slice.size() - 1)];
        const std::size_t n = one.at("samples");
        if (n == 0) continue;
        const double share = static_cast<double>(n) / static_cast<double>(s.n_sampled + n);
        s.value += share * (one.at("variance").get<double>() - s.value);
        s.flatness += share * (one.at("flatness").get<double>() - s.flatness);
        s.independence += share * (one.at("normal_independence").get<double>() - s.independence);
        const auto add_log = [&](double value, double& mean) {  // geometric means
            mean = s.n_sampled == 0 || !(mean > 0) ? value : mean * std::pow(value / mean, share);
        };
        add_log(one.at("spacing"), s.spacing);
        add_log(one.at("normal_variance"), s.normal);
        add_log(one.at("typical_variance"), s.typical);
        s.n_sampled += n;
    }
}

/// lambda at the fewest neighbours that are flat, or at the flattest, over the whole job (NUMERICS
/// 3.2).
NoiseVariance choose_noise(const std::vector<NoiseVariance>& noise) {
    for (const NoiseVariance& n : noise)
        if (n.flatness <= kFlat) return n;
    const auto flatter = [](const auto& a, const auto& b) { return a.flatness < b.flatness; };
    const auto best = std::min_element(noise.begin(), noise.end(), flatter);
    return best == noise.end() ? NoiseVariance{} : *best;
}

void add_counts(const nlohmann::json& one, nlohmann::json& sum) {
    if (sum.is_null()) sum = nlohmann::json::object();
    for (const auto& [key, value] : one.items()) {
        if (key == "recorded") continue;
        if (value.is_object()) {
            if (!sum.contains(key)) sum[key] = nlohmann::json::object();
            add_counts(value, sum[key]);
        } else if (key == "levels") {
            sum[key] = std::max(sum.value(key, std::uint64_t{0}), value.get<std::uint64_t>());
        } else if (value.is_number_unsigned()) {
            sum[key] = sum.value(key, std::uint64_t{0}) + value.get<std::uint64_t>();
        }
    }
}

}  // namespace

std::filesystem::path fit_path(const std::filesystem::path& work, std::size_t slice) {
    return slice_folder(work, slice) / "surfels.fit";
}

std::filesystem::path coarse_fit_path(const std::filesystem::path& work) {
    return work / "coarse.fit";
}

GlobalNoise read_global_noise(const FitConfig& config, const SlicePlan& plan) {
    std::string missing;
    double noisy = 0, points = 0, not_own = 0;
    std::vector<NoiseVariance> noise;
    for (std::size_t i = 0; i < plan.slices.size(); ++i) {
        std::ifstream file(manifest_path(oriented_points_path(config.work, i)));
        const auto manifest = json_or_discarded(file);
        if (manifest.is_discarded() || !manifest.contains("result")) {
            missing += fmt::format(" {}", i);
            continue;
        }
        const auto& r = manifest.at("result");
        add_noise(r.at("noise"), noise);
        noisy += r.at("noisy").get<double>();
        points += r.at("points").get<double>();
        // Missing and turned ones are no more the cloud's own than estimated ones.
        not_own += r.at("points").get<double>() - r.at("kept").get<double>();
    }
    if (!missing.empty())
        throw IncompleteError(fmt::format(
            "{}: normals are missing for slices{}: run `slim normals {}`", config.work, missing,
            config.work));
    GlobalNoise out;
    const NoiseVariance chosen = choose_noise(noise);
    const double measured = chosen.value;
    out.spacing = chosen.spacing;
    out.typical_variance = chosen.typical;
    const double quantum = std::max(plan.coordinate_quantum,
                                    plan.diagonal * std::numeric_limits<double>::epsilon());
    const double floor = 16 * quantum * quantum;
    out.noise_variance = config.lambda > 0 ? config.lambda : std::max(measured, floor);
    out.floored = config.lambda <= 0 && measured < floor;
    out.normals_inform = not_own <= kFewEstimated * points &&
                         chosen.independence >= kIndependent &&
                         normals_inform(chosen.typical, chosen.normal, chosen.spacing);
    out.contrary_share = points > 0 ? noisy / points : 0;
    return out;
}

void check_fit_config(const FitConfig& config) {
    if (config.coarse && (config.slice >= 0 || config.slices_per_task > 1))
        throw ConfigError(
            "--coarse: the coarse levels are of all slices: leave out --slice and "
            "--slices-per-task");
    if (config.radius_rule != "windows") return;
    if (config.degree == "auto" || config.sharp == "on")
        throw ConfigError(
            fmt::format("--radius-rule windows: goes with one degree and without sharp features, "
                        "found --degree {} --sharp {}",
                        config.degree, config.sharp));
}

nlohmann::json run_fit(const FitConfig& config, StageContext& context) {
    check_fit_config(config);
    const FolderLock lock(config.work, FolderLock::Hold::shared);
    const SlicePlan plan = read_plan(config.work);
    if (plan.slices.size() > 1)
        keep_freed_memory_of_balls(plan.n_points / plan.slices.size() * kBytesPerPoint);
    else
        keep_freed_memory(true);
    if (plan.n_points < 3 || !(plan.diagonal > 0))
        throw DataError(fmt::format(
            "{}: {} within a box of diagonal {}: a surface needs at least 3 points that do not "
            "coincide",
            plan.inputs.empty() ? config.work : plan.inputs[0].path,
            plan.n_points == 1 ? "1 point" : fmt::format("{} points", plan.n_points),
            plan.diagonal));
    const GlobalNoise noise = read_global_noise(config, plan);
    const CoverRules rules = rules_of(config, plan, noise);
    const FitDivision division = divide_fit(plan, parse_memory_size(config.memory));
    nlohmann::json sum = nlohmann::json::object();
    bool up_to_date = true;
    if (plan.slices.size() > 1) {
        return_freed_memory();
        const auto coarse = fit_coarse(config, plan, rules, division, context);
        add_counts(coarse, sum);
        up_to_date &= coarse.contains("up_to_date");
    }
    const auto todo = config.coarse ? std::vector<std::size_t>{} : slices_to_do(config, plan);
    for (const std::size_t slice : todo) {
        if (plan.slices.size() > 1) return_freed_memory();
        const auto one = fit_slice(config, plan, rules, slice, division, context);
        add_counts(one, sum);
        up_to_date &= one.contains("up_to_date");
    }
    sum["noise_variance"] = noise.noise_variance;
    sum["noise_variance_floored"] = noise.floored;
    sum["contrary_share"] = noise.contrary_share;
    sum["follow_normals"] = rules.follow_normals;
    if (up_to_date) sum["up_to_date"] = true;
    return sum;
}

}  // namespace slim
