#include "slim/slicing/slab_plan.h"

#include "slim/base/check.h"

#include <algorithm>
#include <numeric>

namespace slim {

std::uint64_t points_in_memory(std::uint64_t memory_bytes) {
    const std::uint64_t left = memory_bytes > kProgramBytes ? memory_bytes - kProgramBytes : 0;
    return std::max<std::uint64_t>(1, left / kBytesPerPoint);
}

std::uint64_t slabs_for_memory(std::uint64_t n_points, std::uint64_t memory_bytes) {
    const std::uint64_t held = points_in_memory(memory_bytes);
    if (n_points <= held) return 1;
    const auto slab = static_cast<std::uint64_t>(static_cast<double>(held) / (1 + 2 * kHaloShare));
    return std::clamp<std::uint64_t>((n_points - 1) / std::max<std::uint64_t>(1, slab) + 1, 1,
                                     kMostSlabs);
}

SlabPlan plan_slabs(const AxisHistogram& histogram, std::uint64_t wanted) {
    SLIM_CHECK(wanted, >=, 1u);
    const auto& counts = histogram.counts();
    const std::uint64_t total = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
    SlabPlan plan;
    std::uint64_t in_slab = 0;
    std::uint64_t left = total;
    std::uint64_t slabs_left = wanted;
    for (std::size_t k = 0; k < counts.size(); ++k) {
        // Cut before this bin if that comes nearer to an equal share of what is left.
        const std::uint64_t share = (in_slab + left) / slabs_left;
        const bool full = in_slab + counts[k] / 2 >= share && in_slab > 0;
        if (full && slabs_left > 1 && left > 0) {
            plan.cuts.push_back(histogram.edge(k));
            plan.n_points.push_back(in_slab);
            in_slab = 0;
            --slabs_left;
        }
        in_slab += counts[k];
        left -= counts[k];
    }
    if (in_slab > 0 || plan.n_points.empty()) plan.n_points.push_back(in_slab);
    return plan;
}

double thinnest_slab(const std::vector<double>& cuts, double lo, double hi) {
    double thinnest = hi - lo, wall = lo;
    for (const double cut : cuts) {
        thinnest = std::min(thinnest, cut - wall);
        wall = cut;
    }
    return std::min(thinnest, hi - wall);
}

std::size_t slab_of(double x, const std::vector<double>& cuts) {
    return static_cast<std::size_t>(std::upper_bound(cuts.begin(), cuts.end(), x) - cuts.begin());
}

}  // namespace slim
