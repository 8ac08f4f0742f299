#include "pipeline/slice_stage.h"

#include "formats/slice_file.h"
#include "pipeline/cloud_survey.h"
#include "pipeline/manifest.h"
#include "pipeline/memory_size.h"
#include "pipeline/peak_memory.h"
#include "slim/base/error.h"
#include "slim/slicing/slab_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace slim {
namespace {

namespace fs = std::filesystem;

// Radii, curvatures and their squares are floats in models and pictures.
constexpr double kLeastDiagonal = 1e-12, kMostDiagonal = 1e12;
// Four steps of the coordinates floor the square root of lambda (NUMERICS 3.2); at this share of the diagonal
// that is a usual fit's error.
constexpr double kCoarseQuantum = 2.5e-5;

std::string names_of(const std::vector<std::string>& paths) {
    return paths.size() == 1 ? paths[0] : fmt::format("{} and {} more", paths[0], paths.size() - 1);
}

void check_survey(const SliceConfig& config, const CloudSurvey& survey) {
    if (survey.n_points == 0)
        throw DataError(fmt::format("{}: no points ({} non-finite dropped)", names_of(config.inputs),
                                    survey.n_dropped));
    const Bbox& b = survey.bounds;
    if (!std::isfinite(b.diagonal()))
        throw DataError(fmt::format(
            "{}: the extent overflows: from ({}, {}, {}) to ({}, {}, {})", names_of(config.inputs),
            b.lo.x, b.lo.y, b.lo.z, b.hi.x, b.hi.y, b.hi.z));
    const double diagonal = b.diagonal();
    if (diagonal > 0 && (diagonal < kLeastDiagonal || diagonal > kMostDiagonal))
        throw DataError(fmt::format(
            "{}: the cloud's diagonal is {:.3g}: expected {:.0e} to {:.0e}, change its unit",
            names_of(config.inputs), diagonal, kLeastDiagonal, kMostDiagonal));
}

Bbox shifted(const Bbox& box, const Vec3d& origin) { return {box.lo - origin, box.hi - origin}; }

/// Cuts across the axis that gives the thickest slabs, as a halo must be thinner: the longest one, unless
/// points crowd there, as on a flat base.
SlabPlan choose_axis(const CloudSurvey& survey, std::uint64_t wanted, int& axis) {
    axis = survey.bounds.longest_axis();
    SlabPlan best = plan_slabs(*survey.histograms[static_cast<std::size_t>(axis)], wanted);
    const auto thinnest = [&](const SlabPlan& slabs, std::size_t a) {
        return thinnest_slab(slabs.cuts, survey.bounds.lo[a], survey.bounds.hi[a]);
    };
    for (std::size_t other = 0; other < 3 && best.n_slabs() > 1; ++other) {
        SlabPlan slabs = plan_slabs(*survey.histograms[other], wanted);
        if (slabs.n_slabs() < best.n_slabs() ||
            !(thinnest(slabs, other) > thinnest(best, static_cast<std::size_t>(axis))))
            continue;
        axis = static_cast<int>(other);
        best = std::move(slabs);
    }
    return best;
}

SlicePlan plan_from_survey(const SliceConfig& config, const CloudSurvey& survey,
                           std::vector<double>& world_cuts) {
    SlicePlan plan;
    plan.inputs = survey.inputs;
    plan.origin = choose_origin(survey.bounds);
    plan.bounds = shifted(survey.bounds, plan.origin);
    plan.diagonal = plan.bounds.diagonal();
    plan.n_points = survey.n_points;
    plan.n_dropped = survey.n_dropped;
    plan.is_float32 = survey.is_float32;
    plan.coordinate_quantum = survey.coordinate_quantum;
    for (const PlanInput& input : survey.inputs) {
        plan.has_normals |= input.has_normals;
        plan.has_scans |= input.has_scan;
    }
    const std::uint64_t wanted =
        config.slices > 0 ? static_cast<std::uint64_t>(config.slices)
                          : slabs_for_memory(plan.n_points, parse_memory_size(config.memory));
    plan.axis = survey.bounds.longest_axis();
    const SlabPlan slabs = survey.gathered.points().empty() ? choose_axis(survey, wanted, plan.axis)
                                                            : SlabPlan{{}, {survey.n_points}};
    const auto axis = static_cast<std::size_t>(plan.axis);
    world_cuts = slabs.cuts;
    for (const double cut : slabs.cuts) plan.cuts.push_back(cut - plan.origin[axis]);
    for (const std::uint64_t n : slabs.n_points) plan.slices.push_back({n, {}});
    return plan;
}

/// Deals points out to the files of their slices.
class Dealer {
public:
    Dealer(const fs::path& work, SlicePlan& plan, const std::vector<double>& world_cuts)
        : plan_(plan), world_cuts_(world_cuts), pending_(plan.slices.size()) {
        for (std::size_t i = 0; i < plan.slices.size(); ++i) {
            fs::create_directories(slice_folder(work, i));
            writers_.emplace_back(slice_points_path(work, i).string(), plan.origin,
                                  plan.slices[i].n_points, plan.has_normals, plan.has_scans);
        }
    }

    void take(const PointChunk& chunk, std::uint64_t first_id, std::size_t input) {
        const auto axis = static_cast<std::size_t>(plan_.axis);
        for (std::size_t i = 0; i < chunk.size(); ++i) {
            const Vec3d& p = chunk.position[i];
            if (!is_finite(p)) continue;
            put(chunk, i, first_id, input, slab_of(p[axis], world_cuts_));
        }
        for (std::size_t s = 0; s < pending_.size(); ++s) flush(s);
    }

    void commit() {
        for (SliceWriter& writer : writers_) writer.commit();
    }

private:
    void put(const PointChunk& chunk, std::size_t i, std::uint64_t first_id, std::size_t input,
             std::size_t slice) {
        PointBlock& block = pending_[slice];
        const Vec3d local = chunk.position[i] - plan_.origin;
        plan_.slices[slice].bounds.extend(local);
        block.position.push_back(local);
        block.id.push_back(first_id + i);
        if (plan_.has_normals) {
            const bool good = !chunk.normal.empty() && is_finite(chunk.normal[i]);
            block.normal.push_back(good ? chunk.normal[i] : Vec3f{});
        }
        if (plan_.has_scans) {
            const std::uint32_t own = chunk.scan.empty() ? 0u : chunk.scan[i];
            block.scan.push_back(static_cast<std::uint16_t>(plan_.inputs[input].first_scan + own));
        }
    }

    void flush(std::size_t slice) {
        PointBlock& block = pending_[slice];
        if (block.empty()) return;
        writers_[slice].append(block);
        block.position.clear();
        block.id.clear();
        block.normal.clear();
        block.scan.clear();
    }

    SlicePlan& plan_;
    const std::vector<double>& world_cuts_;
    std::vector<PointBlock> pending_;
    std::vector<SliceWriter> writers_;
};

/// Writes the one slice of a job whose points were gathered.
PointBlock write_gathered(const fs::path& work, SlicePlan& plan, CloudSurvey& survey) {
    PointBlock points = survey.gathered.release(plan.has_normals, plan.has_scans);
    points.origin = plan.origin;
    for (Vec3d& p : points.position) p -= plan.origin;
    plan.slices[0].bounds = plan.bounds;
    fs::create_directories(slice_folder(work, 0));
    write_slice(slice_points_path(work, 0).string(), points);
    return points;
}

/// How many points are worth keeping while the clouds are read: as many as one slice may have.
std::uint64_t most_gathered(const SliceConfig& config) {
    return config.slices > 1 ? 0 : points_in_memory(parse_memory_size(config.memory));
}

/// Slices of an earlier run with more of them would be taken for ours.
void remove_slices_from(const fs::path& work, std::size_t first) {
    for (std::size_t i = first; fs::exists(slice_folder(work, i)); ++i)
        fs::remove_all(slice_folder(work, i));
}

void make_folder(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error)
        throw IoError(fmt::format("{}: cannot be created: {}", folder.string(), error.message()),
                      ExitCode::usage);
}

void report(const SlicePlan& plan, Reporter& reporter) {
    for (const PlanInput& in : plan.inputs) {
        reporter.info(fmt::format("{}: {}, {} points{}", in.path, in.format, in.n_points,
                                  in.faces_turned ? ", normals from its faces, which are wound inwards: turned"
                                  : in.normals_from_faces ? ", normals from its faces"
                                  : in.has_normals      ? ", with normals"
                                                        : ""));
        if (in.n_dropped > 0)
            reporter.warn(fmt::format("{}: {} of {} points are not finite and were dropped", in.path,
                                      in.n_dropped, in.n_points));
        if (in.n_bad_normals > 0)
            reporter.warn(fmt::format("{}: {} normals are not finite and count as missing", in.path,
                                      in.n_bad_normals));
    }
    if (plan.coordinate_quantum > kCoarseQuantum * plan.diagonal)
        reporter.warn(fmt::format(
            "the coordinates are stored in steps of {} in a cloud of diagonal {:.4g}: finer detail is "
            "lost; store them as doubles, or relative to a nearby origin",
            plan.coordinate_quantum, plan.diagonal));
}

nlohmann::json summary(const SlicePlan& plan) {
    return {{"points", plan.n_points},
            {"dropped", plan.n_dropped},
            {"slices", plan.slices.size()},
            {"diagonal", plan.diagonal},
            {"origin", {plan.origin.x, plan.origin.y, plan.origin.z}},
            {"axis", plan.axis},
            {"has_normals", plan.has_normals},
            {"has_scans", plan.has_scans}};
}

}  // namespace

Vec3d choose_origin(const Bbox& bounds) {
    const double diagonal = bounds.diagonal();
    double largest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
        largest = std::max({largest, std::abs(bounds.lo[axis]), std::abs(bounds.hi[axis])});
    if (!(diagonal > 0) || largest <= 4 * diagonal) return {};
    const double step = std::ldexp(1.0, std::ilogb(diagonal));
    const Vec3d center = bounds.center();
    return {std::round(center.x / step) * step, std::round(center.y / step) * step,
            std::round(center.z / step) * step};
}

nlohmann::json run_slice(const SliceConfig& config, StageContext& context) {
    const fs::path work(config.work);
    parse_memory_size(config.memory);
    make_folder(work);
    Stamp stamp(context, manifest_path(work, "slice"));
    for (const std::string& path : config.inputs) stamp.input(path);
    if (auto result = stamp.up_to_date()) return *result;

    const InputWatch watch(config.inputs);
    const std::uint64_t most = most_gathered(config);
    keep_freed_memory(most > 0);
    CloudSurvey survey = survey_clouds(config.inputs, config.strict, most, context.reporter);
    keep_freed_memory(!survey.gathered.points().empty());
    check_survey(config, survey);
    std::vector<double> world_cuts;
    SlicePlan plan = plan_from_survey(config, survey, world_cuts);
    report(plan, context.reporter);

    // From here the folder is no finished job until the new plan stands in it.
    fs::remove(plan_path(work));
    remove_slices_from(work, plan.slices.size());
    watch.over([&] {
        if (!survey.gathered.points().empty()) {
            PointBlock points = write_gathered(work, plan, survey);
            if (context.handed)
                context.handed->put(slice_points_path(work, 0).string(), std::move(points));
            return;
        }
        Dealer dealer(work, plan, world_cuts);
        for_each_chunk(config.inputs, context.reporter, "slicing",
                       [&](const PointChunk& chunk, std::uint64_t first_id, std::size_t input,
                           const CloudInfo&) { dealer.take(chunk, first_id, input); });
        dealer.commit();
    });
    write_plan(work, plan);

    std::vector<fs::path> outputs{plan_path(work)};
    for (std::size_t i = 0; i < plan.slices.size(); ++i)
        outputs.push_back(slice_points_path(work, i));
    return stamp.commit(outputs, summary(plan), Outlasts::process);
}

}  // namespace slim
