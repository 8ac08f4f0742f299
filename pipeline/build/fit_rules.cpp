#include "pipeline/build/fit_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace slim {
namespace {

// sqrt(lambda) over the spacing between which leaves are fitted again (slim/cover/notes/0010):
// below it the surface is smooth at the points' distance, above it their noise is the larger part
// of what a leaf errs.
constexpr double kSmooth = 0.03, kNoisy = 0.12;

}  // namespace

CoverRules fit_rules(const FitOptions& options, std::uint64_t seed, const SlicePlan& plan,
                     const GlobalNoise& noise) {
    CoverRules rules;
    rules.ladder.choose_degree = options.degree == "auto";
    rules.degree = rules.ladder.choose_degree ? kMaxDegree : options.degree[0] - '0';
    rules.mdl_threshold = options.t_mdl;
    rules.diagonal = plan.diagonal;
    rules.noise_variance = noise.noise_variance;
    rules.least_radius = std::max(2 * plan.coordinate_quantum,
                                  plan.diagonal * std::numeric_limits<double>::epsilon());
    rules.seed = seed;
    rules.windows = options.radius_rule == "windows";
    rules.weight = options.weight == "gauss" ? FitWeight::gauss : FitWeight::polynomial;
    rules.reading = static_cast<CoverReading>(options.cover[0] - 'A');
    rules.sharp = options.sharp == "on" || is_sharp_by_faces(options, plan);
    rules.ask_for_edges = options.sharp == "auto" && !rules.windows && !rules.sharp;
    rules.n_points = plan.n_points;
    rules.ladder.contrary_share = noise.contrary_share;
    rules.ladder.least_sq_error = noise.step_variance;
    rules.spacing = noise.spacing;
    rules.typical_variance = noise.typical_variance;
    rules.stray_density = noise.stray_density;
    rules.lines_are_wires = noise.lines_are_wires;
    rules.are_estimated = noise.are_estimated;
    rules.follow_normals = noise.normals_inform && !rules.windows;
    // Strays and parts with noise are no detail: a second fit would follow them point by point.
    const double roughness = std::sqrt(noise.mean_variance) / noise.spacing;
    rules.refits = !rules.follow_normals && !rules.windows && rules.weight == FitWeight::gauss &&
                   roughness > kSmooth && roughness < kNoisy;
    return rules;
}

bool is_sharp_by_faces(const FitOptions& options, const SlicePlan& plan) {
    return options.sharp == "auto" && options.radius_rule != "windows" && is_made_of_faces(plan);
}

nlohmann::json rules_json(const CoverRules& rules) {
    nlohmann::json out{
        {"degree", rules.degree},
        {"choose_degree", rules.ladder.choose_degree},
        {"t_mdl", rules.mdl_threshold},
        {"diagonal", rules.diagonal},
        {"noise_variance", rules.noise_variance},
        {"typical_variance", rules.typical_variance},
        {"contrary_share", rules.ladder.contrary_share},
        {"spacing", rules.spacing},
        {"radius_rule", rules.windows ? "windows" : "ladder"},
        {"weight", rules.weight == FitWeight::gauss ? "gauss" : "polynomial"},
        {"cover", std::string(1, static_cast<char>('A' + static_cast<int>(rules.reading)))},
        {"sharp", rules.sharp},
        {"follow_normals", rules.follow_normals},
        {"refits", rules.refits},
        {"stray_density", rules.stray_density},
        {"seed", rules.seed}};
    if (rules.lines_are_wires) out["lines_are_wires"] = true;
    if (rules.ladder.least_sq_error > 0) out["step_variance"] = rules.ladder.least_sq_error;
    return out;
}

std::string shared_values(const CoverRules& rules) {
    return fmt::format(
        "lambda {} contrary {} spacing {} typical {} normals {} refits {} strays {} wires {} "
        "estimated {}",
        rules.noise_variance, rules.ladder.contrary_share, rules.spacing, rules.typical_variance,
        rules.follow_normals, rules.refits, rules.stray_density, rules.lines_are_wires,
        rules.are_estimated);
}

}  // namespace slim
