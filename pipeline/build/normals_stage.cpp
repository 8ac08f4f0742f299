#include "pipeline/build/normals_stage.h"

#include "formats/slice_file.h"
#include "pipeline/build/normals_rims.h"
#include "pipeline/build/read_ahead.h"
#include "pipeline/build/scene_signs.h"
#include "pipeline/build/sensors.h"
#include "pipeline/build/slice_normals.h"
#include "pipeline/folder_lock.h"
#include "pipeline/json_text.h"
#include "pipeline/manifest.h"
#include "pipeline/peak_memory.h"
#include "slim/base/error.h"
#include "slim/fit/coordinate_steps.h"
#include "slim/fit/noise_variance.h"
#include "slim/neighbors/point_tree.h"
#include "slim/slicing/block_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace slim {
namespace {

// Points that lambda is the mean over. The smallest eigenvalue deviates from its mean by 0.8
// (happy_stand_raw) to 2.8 times (igea, autzen_stadium) that: 60,000 give the mean to 1 %, which is
// 0.2 % of a radius.
constexpr double kSamples = 60000;
constexpr std::size_t kFewestOfSlice = 100;  // samples of a slice for a mean over many neighbours
constexpr std::uint64_t kBytesKept = 210;    // a point: 136 in use, and what is kept beside it
constexpr std::uint64_t kBytesAhead = 46;    // a point of the next slice

/// Of the samples this slice's share of those that tell of steps.
std::span<const std::uint32_t> step_samples(std::span<const std::uint32_t> samples,
                                            const std::vector<bool>& own, const SlicePlan& plan) {
    constexpr double kFewest = 4;
    const double n_own = static_cast<double>(std::count(own.begin(), own.end(), true));
    const double share = n_own / static_cast<double>(plan.n_points);
    const double wanted = std::max(kFewest, std::ceil(double{kStepSamples} * share));
    return samples.first(std::min(samples.size(), static_cast<std::size_t>(wanted)));
}

struct MeasuredNoise {
    std::vector<NoiseVariance> by_neighbors;  ///< one for each number of neighbours
    CoordinateSteps steps;
};

/// This slice's share of lambda, from points sampled by id at the rate of the whole job. Which
/// number of neighbours counts is decided for all slices together: a job of several measures each,
/// those that are rarely wanted only if this slice is not flat before.
MeasuredNoise noise_of(const PointBlock& points, const NearestSearch& search,
                       const std::vector<bool>& own, const SlicePlan& plan) {
    const std::vector<std::uint32_t> samples =
        sample_points(points, own, kSamples / static_cast<double>(plan.n_points));
    MeasuredNoise out{{}, coordinate_steps(search, step_samples(samples, own, plan))};
    if (plan.slices.size() == 1) {
        out.by_neighbors = {estimate_noise_variance(search, samples, 0, points.normal)};
        return out;
    }
    // All slices together have four times as many as one slice would, or more.
    const std::size_t fewest =
        std::clamp(4 * kFewestSamples / plan.slices.size(), kFewestOfSlice, kFewestSamples);
    for (const std::size_t k : kNoiseNeighbors) {
        out.by_neighbors.push_back(
            estimate_noise_variance(search, samples, k, points.normal, fewest));
        if (k >= kUsualMostNeighbors && out.by_neighbors.back().flatness <= kFlat) break;
    }
    return out;
}

nlohmann::json vector_json(const Vec3d& v) { return {v.x, v.y, v.z}; }
Vec3d vector_of(const nlohmann::json& j) { return {j.at(0), j.at(1), j.at(2)}; }

nlohmann::json evidence_json(const NormalEvidence& e) {
    return {{"normals", e.n},   {"flat", e.n_flat}, {"off", e.n_off},
            {"area", e.area},   {"sq_size", e.sq_size}, {"flux", e.flux},
            {"moment", vector_json(e.moment)}, {"area_vector", vector_json(e.area_vector)},
            {"sq_flux", e.sq_flux}, {"flux_normals", vector_json(e.flux_normals)},
            {"normal_squares", e.normal_squares}};
}

NormalEvidence evidence_from(const nlohmann::json& j) {
    NormalEvidence e;
    j.at("normals").get_to(e.n), j.at("flat").get_to(e.n_flat), j.at("off").get_to(e.n_off);
    j.at("area").get_to(e.area), j.at("sq_size").get_to(e.sq_size), j.at("flux").get_to(e.flux);
    e.moment = vector_of(j.at("moment")), e.area_vector = vector_of(j.at("area_vector"));
    j.at("sq_flux").get_to(e.sq_flux), j.at("normal_squares").get_to(e.normal_squares);
    e.flux_normals = vector_of(j.at("flux_normals"));
    return e;
}

/// Which side is in is known of a whole cloud only.
void warn_of_inward(Reporter& reporter, bool flips) {
    if (flips)
        return reporter.warn(
            "the normals point inwards as --normals flip turns them: leave that out, unless a room "
            "was scanned from inside");
    reporter.warn(
        "the normals point inwards, as those of a room scanned from inside do: of an object, turn "
        "them with --normals flip (curvatures "
        "have the other sign, outlines are ragged else)");
}

/// [bin, samples, sum of variances, of flatness] of each
nlohmann::json bins_json(const VarianceBins& bins) {
    nlohmann::json out = nlohmann::json::array();
    for (const auto& [bin, b] : bins.bins()) out.push_back({bin, b.n, b.variance, b.flatness});
    return out;
}

nlohmann::json steps_json(const CoordinateSteps& s) {
    nlohmann::json axes = nlohmann::json::array();
    for (const CoordinateSteps::Axis& axis : s.axes) axes.push_back({axis.n, axis.sq_step});
    return {{"samples", s.n_sampled},
            {"stepped", s.n_stepped},
            {"rounded", s.n_rounded},
            {"variance", s.variance},
            {"off", s.off},
            {"axes", axes}};
}

nlohmann::json report_json(const NormalsReport& r, const MeasuredNoise& noise, std::size_t n) {
    nlohmann::json measured = nlohmann::json::array();
    for (const NoiseVariance& v : noise.by_neighbors)
        measured.push_back({{"variance", v.value},
                            {"flatness", v.flatness},
                            {"spacing", v.spacing},
                            {"normal_variance", v.normal},
                            {"typical_variance", v.typical},
                            {"line_share", v.line_share},
                            {"normal_independence", v.independence},
                            {"neighbors", v.neighbors},
                            {"samples", v.n_sampled},
                            {"bins", bins_json(v.bins)}});
    return {{"points", n},
            {"kept", r.kept},
            {"turned", r.turned},
            {"of_contrary_scans", r.of_contrary_scans},
            {"of_contrary_patches", r.of_contrary_patches},
            {"estimates_turned", r.estimates_turned},
            {"estimates_widened", r.estimates_widened},
            {"estimated", r.estimated},
            {"neighbors", r.neighbors},
            {"degenerate", r.degenerate},
            {"noisy", r.noisy},
            {"oriented_by_sensor", r.orientation.by_sensor},
            {"oriented_by_neighbors", r.orientation.by_neighbors},
            {"oriented_by_rule", r.orientation.by_rule},
            {"unanchored_components", r.orientation.components},
            {"from_above", r.orientation.from_above},
            {"evidence", evidence_json(r.evidence)},
            {"noise", measured},
            {"coordinate_steps", steps_json(noise.steps)}};
}

/// next: the slice whose points are read ahead
nlohmann::json run_slice_normals(const NormalsConfig& config, const SlicePlan& plan,
                                 std::size_t slice, const std::vector<Vec3d>& sensors,
                                 const std::optional<SceneSigns>& signs, ReadAhead& ahead,
                                 std::optional<std::size_t> next, StageContext& context) {
    const auto input = slice_points_path(config.work, slice);
    const auto output = oriented_points_path(config.work, slice);
    std::optional<PointBlock> handed;
    if (context.handed) handed = context.handed->take(input.string());
    const bool in_memory = handed && !context.writes_handed_points();
    Stamp stamp(context, manifest_path(output));
    if (!in_memory) stamp.input(input);
    stamp.input(plan_path(config.work));
    if (!config.sensors.empty()) stamp.input(config.sensors);
    for (const PlanInput& in : plan.inputs) stamp.optional_input(scans_json_path(in.path));
    for (const std::size_t i : rims(config, plan, slice))
        stamp.input(rim_of(config, plan, i, slice));
    const bool from_above = was_from_above(config, plan, slice);
    stamp.depends(fmt::format("from above {}", from_above));
    if (signs) stamp.input(scene_signs_path(config.work));
    if (!in_memory) {
        stamp.outputs({output});
        if (auto done = stamp.up_to_date()) return *done;
    }
    std::optional<PointBlock> read = ahead.take(slice);
    PointBlock points =
        read ? std::move(*read) : read_with_rims(config, plan, slice, std::move(handed));
    read.reset();
    sort_along_curve(points, plan.bounds);
    const NearestSearch search(points.position);
    const std::vector<bool> own = own_points(plan, slice, points, search.boxes());
    const auto n_own = static_cast<std::size_t>(std::count(own.begin(), own.end(), true));
    std::vector<SampledNormal> sampled;
    if (signs) sampled = signs->of(points);
    // The centroid of a part's piece says little of its outside; the centre of the whole does.
    std::optional<WholeScene> whole;
    if (plan.slices.size() > 1)
        whole = {plan.bounds.center(), signs.has_value(), sampled, signs && signs->is_flat};
    const NormalsReport report = give_normals(points, search, own, whole, config, plan, sensors,
                                              from_above, context.reporter);
    MeasuredNoise noise;
    const auto measure_noise = [&] { noise = noise_of(points, search, own, plan); };
    if (in_memory) measure_noise();
    else {
        SliceWriter writer(output.string(), points.origin, n_own, points.has_normals(),
                           points.has_scans());
        // Neither keeps all threads busy: the file system takes one writer at a time.
        run_both([&] { writer.append(points, own); },
                 [&] { run_both(measure_noise, [&] { ahead.read(config, plan, next); }); });
        context.check_stop();
        writer.commit();
    }
    nlohmann::json found = report_json(report, noise, n_own);
    if (!sensors.empty())
        found["sensors"] = {{"file", config.sensors}, {"hash", sensors_hash(sensors)}};
    nlohmann::json result = stamp.commit(std::move(found), Outlasts::process);
    if (context.handed && plan.slices.size() == 1)
        context.handed->put(output.string(), std::move(points));
    return result;
}

/// throws IncompleteError naming those of the job's slices that are missing
void require_slices(const NormalsConfig& config, const std::vector<std::size_t>& todo) {
    std::string missing;
    for (const std::size_t i : todo)
        if (!std::filesystem::exists(slice_points_path(config.work, i)))
            missing += fmt::format(" {}", i);
    if (!missing.empty())
        throw IncompleteError(fmt::format(
            "{}: the points of these slices are missing:{}: run `slim slice -o {}` again",
            config.work, missing, config.work));
}

std::uint64_t most_of_slice(const SlicePlan& plan) {
    std::uint64_t most = 0;
    for (const PlanSlice& slice : plan.slices) most = std::max(most, slice.n_points);
    return most;
}

/// Whether the arrays of one slice may be kept for the next one: not all find room among them, half
/// as much memory again, which slices do not need where their fits hold wide halos besides.
bool has_room_for_freed(const SlicePlan& plan) {
    if (plan.slices.size() == 1) return true;
    return kBytesKept * most_of_slice(plan) <= kBytesPerPoint * plan.most_within.back();
}

/// Whether the next slice's points may be read before this one's are given back: not where its
/// normals hang on this one's, nor where memory is short.
bool may_read_ahead(const NormalsConfig& config, const SlicePlan& plan) {
    if (plan.slices.size() == 1 || signs_carry_over(config, plan)) return false;
    return (kBytesKept + kBytesAhead) * most_of_slice(plan) <=
           kBytesPerPoint * plan.most_within.back();
}

/// Counts of all slices added up.
void add_counts(const nlohmann::json& one, nlohmann::json& sum) {
    for (const char* key :
         {"points", "kept", "turned", "of_contrary_scans", "of_contrary_patches",
          "estimates_turned", "estimates_widened", "estimated", "degenerate", "noisy",
          "oriented_by_sensor", "oriented_by_neighbors", "oriented_by_rule",
          "unanchored_components"})
        sum[key] = sum.value(key, std::uint64_t{0}) + one.at(key).get<std::uint64_t>();
    sum["neighbors"] = std::max(sum.value("neighbors", std::uint64_t{0}),
                                one.at("neighbors").get<std::uint64_t>());
}

}  // namespace

std::filesystem::path oriented_points_path(const std::filesystem::path& work, std::size_t slice) {
    return slice_folder(work, slice) / "oriented.slice";
}

nlohmann::json run_normals(const NormalsConfig& config, StageContext& context) {
    check_normals_config(config);
    const FolderLock lock(config.work, FolderLock::Hold::shared);
    const SlicePlan plan = read_plan(config.work);
    const auto todo = slices_to_do(config, plan);
    if (context.writes_handed_points()) require_slices(config, todo);
    const bool keeps = has_room_for_freed(plan);
    if (keeps && plan.slices.size() > 1)
        keep_all_freed_memory();
    else
        keep_freed_memory(keeps);
    const std::vector<Vec3d> sensors = read_sensors(config.sensors, plan);
    std::optional<SceneSigns> signs;
    if (plan.slices.size() > 1 && signs_carry_over(config, plan))
        signs = scene_signs(config, plan, sensors, context);
    nlohmann::json sum = nlohmann::json::object();
    bool up_to_date = true;
    NormalEvidence evidence;
    ReadAhead ahead;
    const bool reads_ahead = may_read_ahead(config, plan);
    for (std::size_t i = 0; i < todo.size(); ++i) {
        if (!keeps) return_freed_memory();
        std::optional<std::size_t> next;
        if (reads_ahead && i + 1 < todo.size()) next = todo[i + 1];
        const nlohmann::json one =
            run_slice_normals(config, plan, todo[i], sensors, signs, ahead, next, context);
        add_counts(one, sum);
        evidence += evidence_from(one.at("evidence"));
        up_to_date &= one.contains("up_to_date");
        context.reporter.progress("normals", i + 1, todo.size());
    }
    if (plan.slices.size() > 1) return_freed_memory();
    sum["slices"] = todo.size();
    sum["inward"] = todo.size() == plan.slices.size() && evidence.is_inward();
    if (sum["inward"]) warn_of_inward(context.reporter, config.normals == "flip");
    // Shares of points whose own normal disagrees with its neighbours': turned, or merely noisy.
    const double n = std::max(1.0, sum.value("points", 0.0));
    sum["turned_share"] = sum.value("turned", 0.0) / n;
    sum["disagreeing_share"] = (sum.value("turned", 0.0) + sum.value("noisy", 0.0)) / n;
    sum["estimated_share"] = sum.value("estimated", 0.0) / n;
    if (up_to_date) sum["up_to_date"] = true;
    return sum;
}

}  // namespace slim
