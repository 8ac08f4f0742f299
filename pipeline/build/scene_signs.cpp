#include "pipeline/build/scene_signs.h"

#include "formats/slice_file.h"
#include "pipeline/build/sensors.h"
#include "pipeline/build/slice_normals.h"
#include "pipeline/manifest.h"
#include "slim/neighbors/point_pyramid.h"
#include "slim/neighbors/point_tree.h"

#include <algorithm>
#include <numeric>

namespace slim {
namespace {

constexpr std::uint64_t kFewest = 10000, kMost = 200000;
constexpr std::uint64_t kSeed = 0x7369676e;  // of the hash that says who is in the sample

/// Half of a slice at most: slices are as large as the memory allows.
double share_of_sample(const SlicePlan& plan) {
    std::uint64_t fullest = 0;
    for (const PlanSlice& slice : plan.slices) fullest = std::max(fullest, slice.n_points);
    const std::uint64_t wanted = std::clamp(fullest / 2, kFewest, kMost);
    return std::min(1.0, static_cast<double>(wanted) / static_cast<double>(plan.n_points));
}

PointBlock read_sample(const NormalsConfig& config, const SlicePlan& plan, double share) {
    SliceSelection sample;
    for (std::size_t i = 0; i < plan.slices.size(); ++i)
        sample.add(slice_points_path(config.work, i).string(),
                   [=](std::uint64_t id) { return in_share(kSeed, id, share); });
    PointBlock points;
    sample.append_to(points);
    return points;
}

}  // namespace

std::filesystem::path scene_signs_path(const std::filesystem::path& work) {
    return work / "signs.slice";
}

std::vector<SampledNormal> SceneSigns::of(const PointBlock& points) const {
    std::vector<SampledNormal> out;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (!in_share(kSeed, points.id[i], share_)) continue;
        const auto found = std::lower_bound(id.begin(), id.end(), points.id[i]);
        if (found == id.end() || *found != points.id[i]) continue;
        const auto k = static_cast<std::size_t>(found - id.begin());
        out.push_back({static_cast<std::uint32_t>(i), normal[k]});
    }
    return out;
}

SceneSigns scene_signs(const NormalsConfig& config, const SlicePlan& plan,
                       const std::vector<Vec3d>& sensors, const StageContext& context) {
    const auto path = scene_signs_path(config.work);
    Stamp stamp(context, manifest_path(path));
    for (std::size_t i = 0; i < plan.slices.size(); ++i)
        stamp.input(slice_points_path(config.work, i));
    stamp.input(plan_path(config.work));
    if (!config.sensors.empty()) stamp.input(config.sensors);
    for (const PlanInput& in : plan.inputs) stamp.optional_input(scans_json_path(in.path));
    stamp.outputs({path});
    nlohmann::json result;
    PointBlock points;
    if (const auto done = stamp.up_to_date()) {
        result = *done;
        points = read_slice(path.string());
    } else {
        points = read_sample(config, plan, share_of_sample(plan));
        sort_along_curve(points, plan.bounds);
        const OrientReport report = orient_sample(points, config, sensors);
        write_slice(path.string(), points);
        result =
            stamp.commit({{"points", points.size()}, {"flat", report.flat}}, Outlasts::process);
    }
    std::vector<std::uint32_t> order(points.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return points.id[a] < points.id[b]; });
    SceneSigns signs;
    signs.share_ = share_of_sample(plan);
    signs.is_flat = result.at("flat").get<bool>();
    for (const std::uint32_t i : order) {
        signs.id.push_back(points.id[i]);
        signs.normal.push_back(points.normal[i]);
    }
    return signs;
}

}  // namespace slim
