#include "pipeline/build/slice_planning.h"

#include "pipeline/build/fit_division.h"
#include "pipeline/memory_size.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace slim {
namespace {

// Blocks, over as many as the points alone would fill: with more, every point is read by so many
// slices.
constexpr std::uint64_t kMostDearBlocks = 8;
constexpr double kClearlyDearer = 1.1;  // than fewer blocks: still more will not be cheaper

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
    double excess = INFINITY;  ///< points held at a time beyond those that the memory takes
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

}  // namespace

SlicePlan plan_from_survey(const SliceConfig& config, const CloudSurvey& survey,
                           BlockPlan& blocks) {
    SlicePlan plan;
    plan.inputs = survey.inputs;
    // A few points far off are not what a cloud's size is: they stay, and end as isolated ones.
    const Bbox& box = survey.strays.n > 0 ? survey.strays.box : survey.bounds;
    plan.origin = choose_origin(box);
    plan.bounds = shifted(box, plan.origin);
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

}  // namespace slim
