#include "pipeline/build/slice_stage.h"

#include "formats/slice_file.h"
#include "pipeline/build/cloud_survey.h"
#include "pipeline/build/each_chunk.h"
#include "pipeline/build/fit_division.h"
#include "pipeline/build/input_frames.h"
#include "pipeline/build/input_watch.h"
#include "pipeline/build/point_dealer.h"
#include "pipeline/build/slice_planning.h"
#include "pipeline/build/work_folder.h"
#include "pipeline/folder_lock.h"
#include "pipeline/manifest.h"
#include "pipeline/memory_size.h"
#include "pipeline/noise_over_diagonal.h"
#include "pipeline/peak_memory.h"
#include "slim/base/error.h"
#include "slim/slicing/block_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace slim {
namespace {

namespace fs = std::filesystem;


// Radii, curvatures and their squares are floats in models and pictures.
constexpr double kLeastDiagonal = 1e-12, kMostDiagonal = 1e12;
// Four steps of the coordinates floor the square root of lambda (NUMERICS 3.2); at this share of
// the diagonal that is a usual fit's error.
constexpr double kCoarseQuantum = 2.5e-5;

std::string names_of(const std::vector<std::string>& paths) {
    return paths.size() == 1 ? paths[0] : fmt::format("{} and {} more", paths[0], paths.size() - 1);
}

void check_survey(const SliceConfig& config, const CloudSurvey& survey) {
    if (survey.n_points == 0)
        throw DataError(names_of(config.inputs) + ": no points" +
                        (survey.n_dropped > 0
                             ? fmt::format(" ({} not finite, dropped)", survey.n_dropped)
                             : ""));
    const Bbox& b = survey.bounds;
    if (!std::isfinite(b.diagonal()))
        throw DataError(fmt::format(
            "{}: the extent overflows: from ({}, {}, {}) to ({}, {}, {})", names_of(config.inputs),
            b.lo.x, b.lo.y, b.lo.z, b.hi.x, b.hi.y, b.hi.z));
    const double diagonal = b.diagonal();
    const Vec3d extent = b.extent();  // of which the squares may vanish
    const double extent_most = std::max({diagonal, extent.x, extent.y, extent.z});
    if (extent_most > 0 && (diagonal < kLeastDiagonal || diagonal > kMostDiagonal))
        throw DataError(fmt::format(
            "{}: the cloud's diagonal is {:.3g}: expected {:.0e} to {:.0e}, change its unit",
            names_of(config.inputs), extent_most, kLeastDiagonal, kMostDiagonal));
}

/// Where the slices are too few or the memory too small for a halo that a fit can do with.
void warn_of_memory(const SlicePlan& plan, std::uint64_t memory, Reporter& reporter) {
    if (plan.slices.size() < 2) return;
    const std::uint64_t n = points_held(plan, divide_fit(plan, memory));
    if (n <= points_in_memory(memory)) return;
    reporter.warn(
        fmt::format("{} slices, each with its surroundings, take up to {} MiB, more than --memory",
                    plan.slices.size(), ((kProgramBytes + n * kBytesPerPoint) >> 20) + 1));
}

/// The one slice of a job whose points were gathered: written, handed on, or both.
void pass_on_gathered(const fs::path& work, SlicePlan& plan, CloudSurvey& survey,
                      const StageContext& context) {
    PointBlock points = survey.gathered.release(plan.has_normals, plan.has_scans);
    points.origin = plan.origin;
    for (Vec3d& p : points.position) p -= plan.origin;
    plan.slices[0].bounds = {survey.bounds.lo - plan.origin, survey.bounds.hi - plan.origin};
    const std::string path = slice_points_path(work, 0).string();
    if (context.writes_handed_points()) write_slice(path, points);
    if (context.handed) context.handed->put(path, std::move(points));
}

/// How many points are worth keeping while the clouds are read: as many as one slice may have.
std::uint64_t most_gathered(const SliceConfig& config) {
    return config.slices > 1 ? 0 : points_in_memory(parse_memory_size(config.memory));
}

/// Slices of an earlier run with more of them would be taken for ours. A folder stays that holds
/// files of others too.
void remove_slices_from(const fs::path& work, std::size_t first) {
    for (std::size_t i = first; fs::exists(slice_folder(work, i)); ++i)
        remove_slice_files(slice_folder(work, i));
}

/// The same points twice weigh twice, and their noise seems less than it is.
void warn_of_same_files(const std::vector<std::string>& inputs, Reporter& reporter) {
    for (std::size_t i = 0; i < inputs.size(); ++i)
        for (std::size_t k = 0; k < i; ++k) {
            std::error_code none;
            if (!fs::equivalent(inputs[i], inputs[k], none)) continue;
            reporter.warn(inputs[i] + ": is given twice: its points count twice");
            break;
        }
}

void report(const SlicePlan& plan, Reporter& reporter) {
    for (const PlanInput& in : plan.inputs) {
        reporter.info(fmt::format(
            "{}: {}, {} point{}{}", in.path, in.format, in.n_points - in.n_face_points,
            in.n_points - in.n_face_points == 1 ? "" : "s",
            in.faces_turned         ? ", normals from its faces, which are wound inwards: turned"
            : in.normals_from_faces ? ", normals from its faces"
            : in.has_normals        ? ", with normals"
                                    : ""));
        if (in.n_face_points > 0)
            reporter.info(fmt::format(
                "{}: {} points added on its large faces (--face-points off: vertices alone)",
                in.path, in.n_face_points));
        if (in.face_points_from_size > 0)
            reporter.warn(fmt::format(
                "{}: parts thinner than {:.3g} ask for more points than a mesh is given ({} were "
                "added): discs may stand out of them; thin parts in files of their own get more",
                in.path, in.face_points_from_size, in.n_face_points));
        if (in.noise_variance > 0)
            reporter.info(fmt::format(
                "{}: smoothed: it had noise of {:.2g} of L, for which leaves are made unless "
                "--lambda says another (--t-mdl: finer ones)",
                in.path, noise_over_diagonal(in.noise_variance, plan.diagonal)));
        if (in.n_dropped > 0)
            reporter.warn(fmt::format("{}: {} of {} points are not finite and were dropped",
                                      in.path, in.n_dropped, in.n_points - in.n_face_points));
        if (in.n_bad_normals > 0)
            reporter.warn(fmt::format("{}: {} normals are 0,0,0 or not finite and count as missing",
                                      in.path, in.n_bad_normals));
        if (in.n_undeclared > 0)
            reporter.warn(fmt::format(
                "{}: {} points more than its count says: was it cut or put together? All are read",
                in.path, in.n_undeclared));
    }
    if (plan.n_points < 2 || plan.coordinate_quantum <= kCoarseQuantum * plan.diagonal) return;
    const std::string remedy = "store them as doubles, or relative to a nearby origin";
    reporter.warn(
        plan.diagonal > 0
            ? fmt::format("the coordinates are stored in steps of {} in a cloud of diagonal "
                          "{:.4g}: finer detail is lost; {}",
                          plan.coordinate_quantum, plan.diagonal, remedy)
            : fmt::format("all points are stored at one place; if they differ by less than the "
                          "coordinates' step of {}, {}",
                          plan.coordinate_quantum, remedy));
}

/// Clouds of several frames, and points that are nearly a line or a speck in their extent, for that
/// reason or by themselves.
void warn_of_extent(const SliceConfig& config, const CloudSurvey& survey, Reporter& reporter) {
    const std::string other_frame = other_frame_text(config.inputs, survey.boxes);
    if (!other_frame.empty()) reporter.warn(other_frame);
    // Clouds far apart are a line and specks to each other, whatever they are.
    const bool is_told = !other_frame.empty() && survey.some_have_breadth;
    if (survey.n_points > 2 && survey.spread.is_line() && !is_told)
        reporter.warn(names_of(config.inputs) +
                              ": all points lie on one line: they have no surface, and the "
                              "model may have nothing to draw; are the columns x, y and z?");
    if (const FarStrays::Found& strays = survey.strays; strays.n > 0)
        reporter.warn(fmt::format(
            "{}: {} far from all others, as ({}, {}, {}), {} not counted for the cloud's size: its "
            "diagonal is {:.4g}, not {:.4g}",
            names_of(config.inputs), strays.n == 1 ? "a point" : fmt::format("{} points", strays.n),
            strays.example.x, strays.example.y, strays.example.z, strays.n == 1 ? "is" : "are",
            strays.box.diagonal(), survey.bounds.diagonal()));
    else if (survey.n_points > 2 && survey.spread.has_far_strays() && !is_told)
        reporter.warn(
            fmt::format("{}: a few points lie so far from the others that these are a speck in the "
                        "cloud's extent of {:.3g}, and the "
                        "model, made for that extent, may have nothing to draw of them: take the "
                        "far points out",
                        names_of(config.inputs), survey.bounds.diagonal()));
}

nlohmann::json summary(const SlicePlan& plan) {
    std::uint64_t face_points = 0;
    for (const PlanInput& in : plan.inputs) face_points += in.n_face_points;
    return {{"points", plan.n_points},
            {"face_points", face_points},
            {"dropped", plan.n_dropped},
            {"slices", plan.slices.size()},
            {"diagonal", plan.diagonal},
            {"origin", {plan.origin.x, plan.origin.y, plan.origin.z}},
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
    // A folder that someone names is theirs, whoever made it.
    if (!context.handed) unmark_work(work);
    Stamp stamp(context, manifest_path(work, "slice"));
    for (const std::string& path : config.inputs) stamp.input(path);
    stamp.outputs({plan_path(work)});
    if (auto result = stamp.up_to_date()) return *result;

    const FolderLock lock(config.work);
    const InputWatch watch(config.inputs);
    const std::uint64_t most = most_gathered(config);
    keep_freed_memory(most > 0);
    CloudSurvey survey = survey_clouds(config.inputs, config.strict, most, context.reporter,
                                       config.face_points == "on");
    for (std::size_t i = 0; i < survey.hashes.size(); ++i)
        stamp.know_hash(config.inputs[i], survey.hashes[i]);
    keep_freed_memory(!survey.gathered.points().empty());
    check_survey(config, survey);
    warn_of_extent(config, survey, context.reporter);
    BlockPlan blocks;
    SlicePlan plan = plan_from_survey(config, survey, blocks);
    report(plan, context.reporter);
    warn_of_same_files(config.inputs, context.reporter);
    warn_of_memory(plan, parse_memory_size(config.memory), context.reporter);

    // From here the folder is no finished job until the new plan stands in it.
    fs::remove(plan_path(work));
    remove_slices_from(work, plan.slices.size());
    const bool gathered = !survey.gathered.points().empty();
    watch.over([&] {
        if (gathered) return pass_on_gathered(work, plan, survey, context);
        PointDealer dealer(work, plan, blocks);
        for_each_chunk(config.inputs, context.reporter, "slicing",
                       [&](const PointChunk& chunk, std::uint64_t first_id, std::size_t input,
                           const CloudInfo&) { dealer.take(chunk, first_id, input); },
                       config.face_points == "on");
        dealer.commit();
    });
    write_plan(work, plan);
    // Without a record: points that are in memory alone are nothing to resume from.
    if (gathered && !context.writes_handed_points()) return summary(plan);

    std::vector<fs::path> slices;
    for (std::size_t i = 0; i < plan.slices.size(); ++i)
        slices.push_back(slice_points_path(work, i));
    return stamp.commit(summary(plan), Outlasts::process, slices);
}

}  // namespace slim
