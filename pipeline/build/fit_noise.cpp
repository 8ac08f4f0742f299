#include "pipeline/build/fit_noise.h"

#include "pipeline/build/normals_settings.h"
#include "pipeline/build/normals_stage.h"
#include "pipeline/json_text.h"
#include "pipeline/manifest.h"
#include "slim/base/error.h"
#include "slim/fit/coordinate_steps.h"
#include "slim/fit/noise_variance.h"
#include "slim/fit/normal_variance.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <limits>
#include <vector>

namespace slim {
namespace {

// of the normals: estimated ones tell nothing new of the points
constexpr double kFewEstimated = 0.01;
// lambda over the squared spacing, at most, of points on faces, which have no noise: what edges of
// large turns make of it (slim/fit/noise_variance.cpp has the value of scans)
constexpr double kOfFaceEdges = 0.01;
constexpr double kStrayed = 2;  // the plain mean over lambda: 1 without strays and noisy parts
// times what is measured: noise that smoothing took off. Its normals look clean, and as of a clean
// cloud a few poor ones, which stay beside folds, would end leaves there (slim/smooth/notes/0011).
constexpr double kSmoothed = 2, kContraryOfSmoothed = 0.002;
// Where less lies on lines, these are no scan lines (slim/normals/notes/0007); of 10 points at
// random 0.9 % do, too.
constexpr double kFewestLinesOfWires = 0.015, kMostLinesOfWires = 0.5;

/// Adds a slice's sums, one for each number of neighbours; values stay means over all samples so
/// far. A slice that needed fewer neighbours than others stays as it is at its last: flat.
void add_noise(const nlohmann::json& slice, std::vector<NoiseVariance>& sums) {
    if (slice.empty()) return;
    if (sums.size() < slice.size())
        sums.resize(slice.size(), sums.empty() ? NoiseVariance{} : sums.back());
    for (std::size_t i = 0; i < sums.size(); ++i) {
        NoiseVariance& s = sums[i];
        const nlohmann::json& one = slice[std::min(i, slice.size() - 1)];
        const std::size_t n = one.at("samples");
        if (n == 0) continue;
        const double share = static_cast<double>(n) / static_cast<double>(s.n_sampled + n);
        s.value += share * (one.at("variance").get<double>() - s.value);
        s.flatness += share * (one.at("flatness").get<double>() - s.flatness);
        s.line_share += share * (one.at("line_share").get<double>() - s.line_share);
        s.independence += share * (one.at("normal_independence").get<double>() - s.independence);
        const auto add_log = [&](double value, double& mean) {  // geometric means
            mean = s.n_sampled == 0 || !(mean > 0) ? value : mean * std::pow(value / mean, share);
        };
        add_log(one.at("spacing"), s.spacing);
        add_log(one.at("normal_variance"), s.normal);
        add_log(one.at("typical_variance"), s.typical);
        for (const nlohmann::json& bin : one.at("bins"))
            s.bins.add(bin.at(0), {bin.at(1), bin.at(2), bin.at(3)});
        s.neighbors = std::max(s.neighbors, one.at("neighbors").get<std::size_t>());
        s.n_sampled += n;
    }
}

/// lambda at the fewest neighbours that are flat, or at the flattest, over the whole job
/// (NUMERICS 3.2).
NoiseVariance choose_noise(const std::vector<NoiseVariance>& noise) {
    for (const NoiseVariance& n : noise)
        if (robust_noise(n).flatness <= kFlat) return n;
    const auto flatter = [](const auto& a, const auto& b) {
        return robust_noise(a).flatness < robust_noise(b).flatness;
    };
    const auto best = std::min_element(noise.begin(), noise.end(), flatter);
    return best == noise.end() ? NoiseVariance{} : *best;
}

/// What the manifests of the normals stage say, over all slices.
struct NormalsSaid {
    double noisy = 0, points = 0;
    double not_own = 0;  ///< estimated, missing and turned ones
    double estimated = 0;
    std::vector<NoiseVariance> noise;
    CoordinateSteps steps;
};

CoordinateSteps steps_from(const nlohmann::json& j) {
    CoordinateSteps steps;
    j.at("samples").get_to(steps.n_sampled), j.at("stepped").get_to(steps.n_stepped);
    j.at("rounded").get_to(steps.n_rounded), j.at("variance").get_to(steps.variance);
    j.at("off").get_to(steps.off);
    for (std::size_t a = 0; a < 3; ++a) {
        const nlohmann::json& axis = j.at("axes").at(a);
        axis.at(0).get_to(steps.axes[a].n), axis.at(1).get_to(steps.axes[a].sq_step);
    }
    return steps;
}

/// throws json::exception where the result is another version's
void add_slice(const nlohmann::json& result, NormalsSaid& out) {
    add_noise(result.at("noise"), out.noise);
    out.steps += steps_from(result.at("coordinate_steps"));
    out.noisy += result.at("noisy").get<double>();
    out.points += result.at("points").get<double>();
    // Missing and turned ones are no more the cloud's own than estimated ones.
    out.not_own += result.at("points").get<double>() - result.at("kept").get<double>();
    out.estimated += result.at("estimated").get<double>();
}

NormalsSaid read_normals_manifests(const std::string& work, const SlicePlan& plan) {
    NormalsSaid out;
    NormalsSettings settings;
    std::string missing;
    for (std::size_t i = 0; i < plan.slices.size(); ++i) {
        std::ifstream file(manifest_path(oriented_points_path(work, i)));
        const auto manifest = json_or_discarded(file);
        if (manifest.is_discarded() || !manifest.contains("result")) {
            missing += fmt::format(" {}", i);
            continue;
        }
        try {
            const auto& result = manifest.at("result");
            add_slice(result, out);
            const auto sensors = result.value("sensors", nlohmann::json::object());
            settings.add(i, manifest.value("settings", ""), sensors.value("hash", ""),
                         sensors.value("file", ""));
        } catch (const nlohmann::json::exception&) {
            throw FormatError(
                fmt::format("{}: no manifest of this version: run `slim normals {}` for all slices",
                            manifest_path(oriented_points_path(work, i)).string(), work));
        }
    }
    if (!missing.empty())
        throw IncompleteError(fmt::format(
            "{}: normals are missing for slices{}: run `slim normals {}`", work, missing, work));
    settings.require_same(work);
    return out;
}

double volume_of(const Bbox& box) {
    const Vec3d e = box.extent();
    return e.x * e.y * e.z;
}

}  // namespace

GlobalNoise read_global_noise(const std::string& work, double lambda, const SlicePlan& plan) {
    const NormalsSaid said = read_normals_manifests(work, plan);
    GlobalNoise out;
    const NoiseVariance chosen = choose_noise(said.noise);
    const double sq_spacing = chosen.spacing * chosen.spacing;
    const double most = is_made_of_faces(plan) ? kOfFaceEdges * sq_spacing : INFINITY;
    const double measured = std::min(robust_noise(chosen).variance, most);
    out.spacing = chosen.spacing;
    out.typical_variance = chosen.typical;
    const double line_share = said.noise.empty() ? 0 : said.noise.front().line_share;
    out.lines_are_wires = line_share > kFewestLinesOfWires && line_share < kMostLinesOfWires;
    const double quantum = std::max(plan.coordinate_quantum,
                                    plan.diagonal * std::numeric_limits<double>::epsilon());
    const double floor = 16 * quantum * quantum;
    const double smoothed = smoothed_variance(plan);
    const double stepped = std::min(said.steps.noise_variance(), most);
    const double least = std::max({floor, smoothed, stepped});
    out.noise_variance = lambda > 0 ? lambda : std::max(measured, least);
    out.mean_variance = lambda > 0 ? lambda : std::max(std::min(chosen.value, most), least);
    // Points on faces have no strays.
    const bool is_strayed =
        !is_made_of_faces(plan) && chosen.value > kStrayed * robust_noise(chosen).variance;
    const double volume = volume_of(plan.bounds);
    if (is_strayed && volume > 0)
        out.stray_density = stray_share(chosen) * static_cast<double>(plan.n_points) / volume;
    out.floored = lambda <= 0 && std::max({measured, smoothed, stepped}) < floor;
    if (lambda <= 0) {
        out.step_variance = std::min(said.steps.step_variance(), most);
        out.typical_variance = std::max(out.typical_variance, stepped);
    }
    out.normals_inform = said.not_own <= kFewEstimated * said.points &&
                         chosen.independence >= kIndependent &&
                         normals_inform(chosen.typical, chosen.normal, chosen.spacing);
    out.are_estimated = 2 * said.estimated > said.points;
    // What stands contrary among normals that faces gave is a thin part's other side or an edge.
    const bool are_faces_own =
        is_made_of_faces(plan) && said.not_own <= kFewEstimated * said.points;
    out.contrary_share = said.points > 0 && !are_faces_own ? said.noisy / said.points : 0;
    if (lambda <= 0 && smoothed > kSmoothed * measured) {
        out.contrary_share = std::max(out.contrary_share, kContraryOfSmoothed);
        out.typical_variance = std::max(out.typical_variance, smoothed);
    }
    return out;
}

}  // namespace slim
