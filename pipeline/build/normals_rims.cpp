#include "pipeline/build/normals_rims.h"

#include "formats/slice_file.h"
#include "pipeline/json_text.h"
#include "pipeline/manifest.h"
#include "slim/base/error.h"
#include "slim/slicing/block_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

namespace slim {
namespace {

/// Adds the points of another slice near this one's region. Strictly outside it, as own_points
/// tells them apart: a coordinate of the slice may round to the cut.
void add_rim(const std::filesystem::path& path, const SlicePlan& plan, std::size_t slice,
             SliceSelection& points) {
    const Bbox& region = plan.slices[slice].region;
    const double width = rim_width(plan);
    const auto wanted_of = [&](const Bbox& box) {
        if (!comes_near(region, box, width)) return WantedOf::none;
        return is_near(region, box, width) && !comes_near(region, box, 0) ? WantedOf::all
                                                                          : WantedOf::some;
    };
    points.add(path.string(), wanted_of,
               [&](const Vec3d& p) { return is_near(region, p, width) && !is_near(region, p, 0); });
}

}  // namespace

bool signs_carry_over(const NormalsConfig& config, const SlicePlan& plan) {
    return config.normals != "keep" && (!plan.has_normals || config.normals == "estimate");
}

std::filesystem::path rim_of(const NormalsConfig& config, const SlicePlan& plan, std::size_t other,
                             std::size_t slice) {
    if (!signs_carry_over(config, plan) || other > slice)
        return slice_points_path(config.work, other);
    const auto path = oriented_points_path(config.work, other);
    if (!std::filesystem::exists(manifest_path(path)))
        throw IncompleteError(
            fmt::format("{}: slice {} takes the signs of its normals from slice {}, which has none "
                        "yet: run `slim "
                        "normals {}` for all slices",
                        config.work, slice, other, config.work));
    return path;
}

std::vector<std::size_t> rims(const NormalsConfig& config, const SlicePlan& plan,
                              std::size_t slice) {
    std::vector<std::size_t> near;
    for (const std::size_t i : slices_near(plan, slice, rim_width(plan)))
        if (i != slice) near.push_back(i);
    if (signs_carry_over(config, plan) && slice > 0 &&
        std::find(near.begin(), near.end(), slice - 1) == near.end())
        near.push_back(slice - 1);
    return near;
}

bool was_from_above(const NormalsConfig& config, const SlicePlan& plan, std::size_t slice) {
    if (slice == 0 || !signs_carry_over(config, plan)) return false;
    const auto path = manifest_path(rim_of(config, plan, slice - 1, slice));
    std::ifstream file(path);
    const auto manifest = json_or_discarded(file);
    const auto said = nlohmann::json::json_pointer("/result/from_above");
    if (!manifest.is_object() || !manifest.contains(said) || !manifest.at(said).is_boolean())
        throw FormatError(
            fmt::format("{}: no manifest of this version: run `slim normals {}` for all slices",
                        path.string(), config.work));
    return manifest.at(said).get<bool>();
}

PointBlock read_with_rims(const NormalsConfig& config, const SlicePlan& plan, std::size_t slice,
                          std::optional<PointBlock> handed) {
    const auto near = rims(config, plan, slice);
    SliceSelection read;
    if (!handed) read.add(slice_points_path(config.work, slice).string());
    const auto add_rims = [&](bool before, SliceSelection& to) {
        for (const std::size_t i : near)
            if ((i < slice) == before) add_rim(rim_of(config, plan, i, slice), plan, slice, to);
    };
    PointBlock points;
    if (handed) points = std::move(*handed);
    add_rims(false, read);
    if (!signs_carry_over(config, plan)) {
        add_rims(true, read);
        read.append_to(points);
    } else {
        read.append_to(points);
        points.normal.assign(points.size(), Vec3f{});
        SliceSelection oriented;
        add_rims(true, oriented);
        oriented.append_to(points);
    }
    if (!points.has_normals()) points.normal.assign(points.size(), Vec3f{});  // --normals keep
    return points;
}

std::vector<bool> own_points(const SlicePlan& plan, std::size_t slice, const PointBlock& points,
                             const BoxTree& boxes) {
    if (plan.slices.size() == 1) return std::vector<bool>(points.size(), true);
    const Bbox& region = plan.slices[slice].region;
    std::vector<bool> own(points.size());
    const auto at = [&](std::size_t i) { return own.begin() + static_cast<std::ptrdiff_t>(i); };
    std::size_t whole = 0;  // buckets from there up to the next one are all own
    for (std::size_t begin = 0; begin < points.size(); begin += BoxTree::kBucket) {
        const std::size_t end = std::min(begin + BoxTree::kBucket, points.size());
        const Bbox box = boxes.bucket(begin / BoxTree::kBucket);
        if (is_near(region, box, 0)) continue;
        std::fill(at(whole), at(begin), true);
        whole = end;
        if (!comes_near(region, box, 0)) continue;
        for (std::size_t i = begin; i < end; ++i) own[i] = is_near(region, points.position[i], 0);
    }
    std::fill(at(whole), own.end(), true);
    return own;
}

}  // namespace slim
