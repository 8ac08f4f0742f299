#include "pipeline/build/plan_file.h"

#include "formats/atomic_file.h"
#include "pipeline/build/fit_division.h"
#include "pipeline/json_text.h"
#include "slim/base/error.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace slim {
namespace {

using nlohmann::json;

/// Version 2 has blocks where version 1 had slabs: older plans are not read, the slices are made
/// anew.
constexpr int kVersion = 2;

json to_json(const Vec3d& v) { return {v.x, v.y, v.z}; }
Vec3d vec_from(const json& j) {
    return {j.at(0).get<double>(), j.at(1).get<double>(), j.at(2).get<double>()};
}
json to_json(const Bbox& b) { return {{"lo", to_json(b.lo)}, {"hi", to_json(b.hi)}}; }
Bbox box_from(const json& j) { return {vec_from(j.at("lo")), vec_from(j.at("hi"))}; }

/// Infinite sides are null.
Bbox region_from(const json& j) {
    Bbox region;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const json &lo = j.at("lo").at(axis), &hi = j.at("hi").at(axis);
        region.lo[axis] = lo.is_null() ? -INFINITY : lo.get<double>();
        region.hi[axis] = hi.is_null() ? INFINITY : hi.get<double>();
    }
    return region;
}

json to_json(const PlanInput& in) {
    return {{"path", in.path},
            {"format", in.format},
            {"points", in.n_points},
            {"dropped", in.n_dropped},
            {"bad_normals", in.n_bad_normals},
            {"has_normals", in.has_normals},
            {"normals_from_faces", in.normals_from_faces},
            {"faces_turned", in.faces_turned},
            {"face_points", in.n_face_points},
            {"has_scan", in.has_scan},
            {"noise_variance", in.noise_variance},
            {"first_id", in.first_id},
            {"first_scan", in.first_scan}};
}

PlanInput input_from(const json& j) {
    PlanInput in;
    j.at("path").get_to(in.path);
    j.at("format").get_to(in.format);
    j.at("points").get_to(in.n_points);
    j.at("dropped").get_to(in.n_dropped);
    j.at("bad_normals").get_to(in.n_bad_normals);
    j.at("has_normals").get_to(in.has_normals);
    j.at("normals_from_faces").get_to(in.normals_from_faces);
    j.at("faces_turned").get_to(in.faces_turned);
    j.at("face_points").get_to(in.n_face_points);
    j.at("has_scan").get_to(in.has_scan);
    in.noise_variance = j.value("noise_variance", 0.0);
    j.at("first_id").get_to(in.first_id);
    j.at("first_scan").get_to(in.first_scan);
    return in;
}

json to_json(const SlicePlan& plan) {
    json inputs = json::array();
    for (const PlanInput& in : plan.inputs) inputs.push_back(to_json(in));
    json slices = json::array();
    for (const PlanSlice& s : plan.slices)
        slices.push_back({{"points", s.n_points},
                          {"bounds", to_json(s.bounds)},
                          {"region", to_json(s.region)}});
    return {{"version", kVersion},
            {"inputs", inputs},
            {"origin", to_json(plan.origin)},
            {"bounds", to_json(plan.bounds)},
            {"diagonal", plan.diagonal},
            {"points", plan.n_points},
            {"dropped", plan.n_dropped},
            {"spacing", plan.spacing},
            {"slices", slices},
            {"slices_given", plan.slices_given},
            {"most_within", plan.most_within},
            {"all_within", plan.all_within},
            {"has_normals", plan.has_normals},
            {"has_scans", plan.has_scans},
            {"float32", plan.is_float32},
            {"coordinate_quantum", plan.coordinate_quantum}};
}

SlicePlan plan_from(const json& j) {
    SlicePlan plan;
    for (const json& in : j.at("inputs")) plan.inputs.push_back(input_from(in));
    plan.origin = vec_from(j.at("origin"));
    plan.bounds = box_from(j.at("bounds"));
    j.at("diagonal").get_to(plan.diagonal);
    j.at("points").get_to(plan.n_points);
    j.at("dropped").get_to(plan.n_dropped);
    j.at("spacing").get_to(plan.spacing);
    j.at("slices_given").get_to(plan.slices_given);
    j.at("most_within").get_to(plan.most_within);
    j.at("all_within").get_to(plan.all_within);
    for (const json& s : j.at("slices"))
        plan.slices.push_back({s.at("points").get<std::uint64_t>(), box_from(s.at("bounds")),
                               region_from(s.at("region"))});
    j.at("has_normals").get_to(plan.has_normals);
    j.at("has_scans").get_to(plan.has_scans);
    j.at("float32").get_to(plan.is_float32);
    j.at("coordinate_quantum").get_to(plan.coordinate_quantum);
    if (plan.slices.empty()) throw FormatError("there are no slices");
    const std::size_t n_halos = plan.slices.size() > 1 ? possible_halos(plan.diagonal).size() : 0;
    if (plan.most_within.size() != n_halos || plan.all_within.size() != n_halos)
        throw FormatError("the numbers of points within the halos are missing");
    std::uint64_t n = 0;
    for (const PlanSlice& s : plan.slices) n += s.n_points;
    if (n != plan.n_points) throw FormatError("the points of the slices do not add up");
    if (!(plan.spacing >= 0) || !(plan.diagonal >= 0)) throw FormatError("a length is negative");
    for (const std::uint64_t most : plan.most_within)
        if (most > n) throw FormatError("a slice holds more points than there are");
    return plan;
}

int version_of(const json& j) { return j.at("version").get<int>(); }

}  // namespace

bool is_made_of_faces(const SlicePlan& plan) {
    return std::all_of(plan.inputs.begin(), plan.inputs.end(), [](const PlanInput& in) {
        return 2 * in.n_face_points > in.n_points;
    });
}

double smoothed_variance(const SlicePlan& plan) {
    double sum = 0, n = 0;
    for (const PlanInput& in : plan.inputs) {
        n += static_cast<double>(in.n_points);
        sum += static_cast<double>(in.n_points) * in.noise_variance;
    }
    return n > 0 ? sum / n : 0;
}

std::filesystem::path plan_path(const std::filesystem::path& work) { return work / "plan.json"; }

std::filesystem::path slice_folder(const std::filesystem::path& work, std::size_t slice) {
    return work / fmt::format("slice_{:04}", slice);
}

std::filesystem::path slice_points_path(const std::filesystem::path& work, std::size_t slice) {
    return slice_folder(work, slice) / "points.slice";
}

std::vector<std::size_t> slices_near(const SlicePlan& plan, std::size_t slice, double distance) {
    const Bbox& region = plan.slices[slice].region;
    std::vector<std::size_t> near;
    for (std::size_t i = 0; i < plan.slices.size(); ++i) {
        const Bbox& other = plan.slices[i].bounds;
        bool meets = true;
        for (std::size_t axis = 0; axis < 3; ++axis)
            meets &= other.lo[axis] <= region.hi[axis] + distance &&
                     other.hi[axis] >= region.lo[axis] - distance;
        if (meets || i == slice) near.push_back(i);
    }
    return near;
}

double rim_width(const SlicePlan& plan) {
    constexpr double kWidest = 0.05, kSpacings = 24;  // of L, and of L / sqrt(n)
    return plan.diagonal * std::min(kWidest, kSpacings / std::sqrt(double(plan.n_points)));
}

void write_plan(const std::filesystem::path& work, const SlicePlan& plan) {
    write_file_atomically(plan_path(work).string(), text_of(to_json(plan), 2) + "\n",
                          Outlasts::process);
}

SlicePlan read_plan(const std::filesystem::path& work) {
    const std::string path = plan_path(work).string();
    if (!std::filesystem::exists(path))
        throw IoError(fmt::format("{}: cannot be opened; run the slice stage first", path));
    const json j = read_json(path);
    try {
        if (version_of(j) > kVersion)
            throw FormatError(
                fmt::format("written by a newer slim: version {}, this one reads up to {}",
                            version_of(j), kVersion));
        if (version_of(j) < kVersion)
            throw FormatError(fmt::format(
                "of an older slim: version {}, this one reads {}: run `slim slice` again",
                version_of(j), kVersion));
        return plan_from(j);
    } catch (const json::exception&) {
        throw FormatError(Fault{.file = path,
                                .problem = "not a slice plan",
                                .expected = "a version, inputs, slices and the other keys that "
                                            "`slim slice` writes: run it again"});
    } catch (const FormatError& error) {
        throw FormatError(fmt::format("{}: {}", path, error.what()));
    }
}

}  // namespace slim
