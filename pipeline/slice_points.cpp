#include "pipeline/slice_points.h"

#include "formats/slice_file.h"
#include "pipeline/normals_stage.h"
#include "slim/cover/level_cover.h"
#include "slim/neighbors/point_pyramid.h"
#include "slim/slicing/slab_plan.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr int kFinestLevel = 40;

}  // namespace

FitDivision divide_fit(const SlicePlan& plan, std::uint64_t memory_bytes) {
    FitDivision out;
    if (plan.slices.size() < 2) return out;
    const auto axis = static_cast<std::size_t>(plan.axis);
    const double widest =
        kHaloShare * thinnest_slab(plan.cuts, plan.bounds.lo[axis], plan.bounds.hi[axis]);
    const auto halo_of = [&](int level) { return level_radius(plan.diagonal, level - kHaloRungs); };
    while (out.first_fine < kFinestLevel && halo_of(out.first_fine) > widest) ++out.first_fine;
    out.halo = halo_of(out.first_fine);
    out.share = std::min(1.0, static_cast<double>(points_in_memory(memory_bytes)) /
                                  static_cast<double>(std::max<std::uint64_t>(plan.n_points, 1)));
    return out;
}

PointBlock read_with_halo(const std::string& work, const SlicePlan& plan, std::size_t slice,
                          double halo) {
    PointBlock block;
    const double lo = slice == 0 ? -INFINITY : plan.cuts[slice - 1] - halo;
    const double hi = slice == plan.cuts.size() ? INFINITY : plan.cuts[slice] + halo;
    const std::size_t first = slice > 0 ? slice - 1 : 0;
    for (std::size_t i = first; i < std::min(slice + 2, plan.slices.size()); ++i)
        append_slice_part(oriented_points_path(work, i).string(), plan.axis, lo, hi, block);
    return block;
}

PointBlock read_coarse_sample(const std::string& work, const SlicePlan& plan, double share,
                              std::uint64_t seed) {
    PointBlock sample;
    const auto is_wanted = [=](std::uint64_t id) { return in_share(seed, id, share); };
    for (std::size_t i = 0; i < plan.slices.size(); ++i)
        append_slice_points(oriented_points_path(work, i).string(), is_wanted, sample);
    return sample;
}

}  // namespace slim
