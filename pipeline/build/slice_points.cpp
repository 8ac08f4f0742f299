#include "pipeline/build/slice_points.h"

#include "formats/slice_file.h"
#include "pipeline/build/normals_stage.h"
#include "slim/neighbors/point_pyramid.h"
#include "slim/slicing/block_plan.h"

namespace slim {
PointBlock read_with_halo(const std::string& work, const SlicePlan& plan, std::size_t slice,
                          double halo) {
    if (plan.slices.size() == 1) return read_slice(oriented_points_path(work, 0).string());
    const Bbox& region = plan.slices[slice].region;
    const auto wanted_of = [&](const Bbox& box) {
        if (!comes_near(region, box, halo)) return WantedOf::none;
        return is_near(region, box, halo) ? WantedOf::all : WantedOf::some;
    };
    SliceSelection points;
    for (const std::size_t i : slices_near(plan, slice, halo))
        points.add(oriented_points_path(work, i).string(), wanted_of,
                   [&](const Vec3d& p) { return is_near(region, p, halo); });
    PointBlock block;
    points.append_to(block);
    return block;
}

PointBlock read_coarse_sample(const std::string& work, const SlicePlan& plan, double share,
                              std::uint64_t seed) {
    SliceSelection sample;
    for (std::size_t i = 0; i < plan.slices.size(); ++i)
        sample.add(oriented_points_path(work, i).string(),
                   [=](std::uint64_t id) { return in_share(seed, id, share); });
    PointBlock block;
    sample.append_to(block);
    return block;
}

}  // namespace slim
