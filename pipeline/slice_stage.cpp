#include "pipeline/slice_stage.h"

#include "formats/slice_file.h"
#include "pipeline/cloud_survey.h"
#include "pipeline/fit_division.h"
#include "pipeline/manifest.h"
#include "pipeline/memory_size.h"
#include "pipeline/peak_memory.h"
#include "slim/base/error.h"
#include "slim/slicing/block_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <utility>

namespace slim {
namespace {

namespace fs = std::filesystem;

// Radii, curvatures and their squares are floats in models and pictures.
constexpr double kLeastDiagonal = 1e-12, kMostDiagonal = 1e12;
// Four steps of the coordinates floor the square root of lambda (NUMERICS 3.2); at this share of
// the diagonal that is a usual fit's error.
constexpr double kCoarseQuantum = 2.5e-5;
// Blocks, over as many as the points alone would fill: with more, every point is read by so many
// slices.
constexpr std::uint64_t kMostDearBlocks = 8;
constexpr double kClearlyDearer = 1.1;  // than fewer blocks: still more will not be cheaper

std::string names_of(const std::vector<std::string>& paths) {
    return paths.size() == 1 ? paths[0] : fmt::format("{} and {} more", paths[0], paths.size() - 1);
}

void check_survey(const SliceConfig& config, const CloudSurvey& survey) {
    if (survey.n_points == 0)
        throw DataError(names_of(config.inputs) + ": no points" +
                        (survey.n_dropped > 0 ? fmt::format(" ({} not finite, dropped)", survey.n_dropped) : ""));
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

Bbox shifted(const Bbox& box, const Vec3d& origin) { return {box.lo - origin, box.hi - origin}; }

/// Takes the blocks, their counts and what they hold with a halo into the plan.
void set_blocks(const BlockPlan& blocks, const std::vector<Cell>& cells, double width,
                SlicePlan& plan) {
    plan.slices.clear();
    for (std::size_t i = 0; i < blocks.n_blocks(); ++i)
        plan.slices.push_back({blocks.n_points[i], {}, shifted(blocks.regions[i], plan.origin)});
    HaloCounts within;
    if (blocks.n_blocks() > 1)
        within = count_within(blocks, cells, width, possible_halos(plan.diagonal));
    plan.most_within = std::move(within.most);
    plan.all_within = std::move(within.all);
}

/// How slices do for the fit.
struct FitCost {
    /// infinite where memory leaves no room for the halo that the fit wants
    double points_read = INFINITY;
    double excess = INFINITY;       ///< points held at a time beyond those that the memory takes
    double halo = 0;

    /// Fewer points read; where neither suffices, less excess, then the wider halo.
    bool better_than(const FitCost& other) const {
        if (points_read < INFINITY || other.points_read < INFINITY)
            return points_read < other.points_read;
        return std::pair(-excess, halo) > std::pair(-other.excess, other.halo);
    }
};

FitCost cost_of_fit(const SlicePlan& plan, std::uint64_t memory) {
    const FitDivision division = divide_fit(plan, memory);
    const std::uint64_t held = points_held(plan, division), room = points_in_memory(memory);
    FitCost cost;
    if (halo_suffices(plan, division) && held <= room)
        cost.points_read = static_cast<double>(points_read(plan, division));
    cost.excess = std::max(0.0, static_cast<double>(held) - static_cast<double>(room));
    cost.halo = division.halo;
    return cost;
}

/// As many blocks as leave room for the halo that the fit wants and have it read the fewest points,
/// or if no reasonable number does, as many as leave room for the widest.
BlockPlan blocks_for_memory(const std::vector<Cell>& cells, double cell_width, std::uint64_t memory,
                            SlicePlan& plan) {
    const std::uint64_t least = (plan.n_points - 1) / points_in_memory(memory) + 1;
    const std::uint64_t most = least < 2 ? 1 : std::min(kMostDearBlocks * least, kMostBlocks);
    BlockPlan best;
    FitCost best_cost;
    for (std::uint64_t n = std::min(least, most); n <= most; n += 1 + n / 8) {
        BlockPlan blocks = plan_blocks(cells, cell_width, n);
        set_blocks(blocks, cells, cell_width, plan);
        if (plan.slices.size() < 2) return blocks;
        const FitCost cost = cost_of_fit(plan, memory);
        if (cost.points_read > kClearlyDearer * best_cost.points_read) break;
        if (!cost.better_than(best_cost)) continue;
        best = std::move(blocks);
        best_cost = cost;
    }
    set_blocks(best, cells, cell_width, plan);
    return best;
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

/// The blocks, in the world's frame, and the slices that they make.
void plan_slices(const SliceConfig& config, const CloudSurvey& survey, BlockPlan& blocks,
                 SlicePlan& plan) {
    const std::vector<Cell> cells = survey.cells->cells();
    const double width = survey.cells->width();
    plan.spacing = surface_spacing(cells, width);
    if (plan.slices_given) {
        blocks = plan_blocks(cells, width, static_cast<std::uint64_t>(config.slices));
        set_blocks(blocks, cells, width, plan);
    } else {
        blocks = blocks_for_memory(cells, width, parse_memory_size(config.memory), plan);
    }
}

/// The plan and the blocks, in the world's frame; none of points that were gathered.
SlicePlan plan_from_survey(const SliceConfig& config, const CloudSurvey& survey,
                           BlockPlan& blocks) {
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
    plan.slices_given = config.slices > 0;
    if (survey.gathered.points().empty()) plan_slices(config, survey, blocks, plan);
    if (plan.slices.size() > 1) return plan;
    // The same plan, whether the cells of its one slice were counted or not.
    const Vec3d far{INFINITY, INFINITY, INFINITY};
    plan.slices = {{survey.n_points, {}, {far * -1.0, far}}};
    plan.spacing = 0;
    return plan;
}

/// Deals points out to the files of their slices. Holds one slice's points of one chunk at a time.
class Dealer {
public:
    Dealer(const fs::path& work, SlicePlan& plan, const BlockPlan& blocks)
        : plan_(plan), blocks_(blocks) {
        for (std::size_t i = 0; i < plan.slices.size(); ++i) {
            fs::create_directories(slice_folder(work, i));
            writers_.emplace_back(slice_points_path(work, i).string(), plan.origin,
                                  plan.slices[i].n_points, plan.has_normals, plan.has_scans);
        }
    }

    void take(const PointChunk& chunk, std::uint64_t first_id, std::size_t input) {
        sort_by_slice(chunk);
        for (std::size_t s = 0; s < writers_.size(); ++s) {
            if (begin_[s] == begin_[s + 1]) continue;
            block_.position.clear();
            block_.id.clear();
            block_.normal.clear();
            block_.scan.clear();
            for (std::size_t k = begin_[s]; k < begin_[s + 1]; ++k)
                put(chunk, order_[k], first_id, input, s);
            writers_[s].append(block_);
        }
    }

    void commit() {
        for (SliceWriter& writer : writers_) writer.commit();
    }

private:
    /// Fills order_ with the chunk's finite points, those of slice s from begin_[s] on, in their
    /// order.
    void sort_by_slice(const PointChunk& chunk) {
        slice_of_.assign(chunk.size(), 0);
        begin_.assign(writers_.size() + 1, 0);
        for (std::size_t i = 0; i < chunk.size(); ++i) {
            if (!is_finite(chunk.position[i])) continue;
            slice_of_[i] = blocks_.block_of(chunk.position[i]);
            ++begin_[slice_of_[i] + 1];
        }
        std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
        order_.resize(begin_.back());
        std::vector<std::size_t> at(begin_.begin(), begin_.end() - 1);
        for (std::size_t i = 0; i < chunk.size(); ++i)
            if (is_finite(chunk.position[i])) order_[at[slice_of_[i]]++] = i;
    }

    void put(const PointChunk& chunk, std::size_t i, std::uint64_t first_id, std::size_t input,
             std::size_t slice) {
        const Vec3d local = chunk.position[i] - plan_.origin;
        plan_.slices[slice].bounds.extend(local);
        block_.position.push_back(local);
        block_.id.push_back(first_id + i);
        if (plan_.has_normals) {
            const bool good = !chunk.normal.empty() && is_finite(chunk.normal[i]);
            block_.normal.push_back(good ? chunk.normal[i] : Vec3f{});
        }
        if (plan_.has_scans) {
            const std::uint32_t own = chunk.scan.empty() ? 0u : chunk.scan[i];
            block_.scan.push_back(static_cast<std::uint16_t>(plan_.inputs[input].first_scan + own));
        }
    }

    SlicePlan& plan_;
    const BlockPlan& blocks_;
    std::vector<SliceWriter> writers_;
    std::vector<std::size_t> slice_of_, begin_, order_;  // of a chunk
    PointBlock block_;
};

/// The one slice of a job whose points were gathered: written, handed on, or both.
void pass_on_gathered(const fs::path& work, SlicePlan& plan, CloudSurvey& survey,
                      const StageContext& context) {
    PointBlock points = survey.gathered.release(plan.has_normals, plan.has_scans);
    points.origin = plan.origin;
    for (Vec3d& p : points.position) p -= plan.origin;
    plan.slices[0].bounds = plan.bounds;
    fs::create_directories(slice_folder(work, 0));
    const std::string path = slice_points_path(work, 0).string();
    if (context.writes_handed_points()) write_slice(path, points);
    if (context.handed) context.handed->put(path, std::move(points));
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
            "{}: {}, {} point{}{}", in.path, in.format, in.n_points, in.n_points == 1 ? "" : "s",
            in.faces_turned         ? ", normals from its faces, which are wound inwards: turned"
            : in.normals_from_faces ? ", normals from its faces"
            : in.has_normals        ? ", with normals"
                                    : ""));
        if (in.n_dropped > 0)
            reporter.warn(fmt::format("{}: {} of {} points are not finite and were dropped",
                                      in.path, in.n_dropped, in.n_points));
        if (in.n_bad_normals > 0)
            reporter.warn(fmt::format("{}: {} normals are not finite and count as missing", in.path,
                                      in.n_bad_normals));
    }
    if (plan.n_points > 1 && plan.coordinate_quantum > kCoarseQuantum * plan.diagonal)
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
    if (survey.n_points > 2 && survey.spread.is_line())
        context.reporter.warn(names_of(config.inputs) +
                              ": all points lie on one line: they have no surface, and the "
                              "model may have nothing to draw");
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
        Dealer dealer(work, plan, blocks);
        for_each_chunk(config.inputs, context.reporter, "slicing",
                       [&](const PointChunk& chunk, std::uint64_t first_id, std::size_t input,
                           const CloudInfo&) { dealer.take(chunk, first_id, input); });
        dealer.commit();
    });
    write_plan(work, plan);
    // Without a record: points that are in memory alone are nothing to resume from.
    if (gathered && !context.writes_handed_points()) return summary(plan);

    std::vector<fs::path> outputs{plan_path(work)};
    for (std::size_t i = 0; i < plan.slices.size(); ++i)
        outputs.push_back(slice_points_path(work, i));
    return stamp.commit(outputs, summary(plan), Outlasts::process);
}

}  // namespace slim
