#include "pipeline/slice_points.h"

#include "formats/slice_file.h"
#include "pipeline/normals_stage.h"
#include "slim/neighbors/point_pyramid.h"
#include "slim/slicing/block_plan.h"

namespace slim {
namespace {

/// Of the fullest slice with its halo.
std::uint64_t most_points(const SlicePlan& plan, double halo) {
    const std::vector<double> halos = possible_halos(plan.diagonal);
    for (std::size_t h = halos.size(); h-- > 0;)
        if (halos[h] >= halo) return plan.most_within.at(h);
    return plan.n_points;
}

/// Room that is not used takes none of the memory.
void reserve(std::uint64_t n, const SlicePlan& plan, PointBlock& block) {
    block.position.reserve(n);
    block.id.reserve(n);
    block.normal.reserve(n);  // oriented points have one
    if (plan.has_scans) block.scan.reserve(n);
}

}  // namespace

PointBlock read_with_halo(const std::string& work, const SlicePlan& plan, std::size_t slice,
                          double halo) {
    PointBlock block;
    if (plan.slices.size() == 1) return read_slice(oriented_points_path(work, 0).string());
    const Bbox& region = plan.slices[slice].region;
    reserve(most_points(plan, halo), plan, block);
    for (const std::size_t i : slices_near(plan, slice, halo))
        append_slice_part(oriented_points_path(work, i).string(),
                          [&](const Vec3d& p) { return is_near(region, p, halo); }, block);
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
