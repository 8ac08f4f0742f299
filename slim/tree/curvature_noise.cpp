#include "slim/tree/curvature_noise.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

namespace slim {
namespace {

constexpr double kTimes = 140;
constexpr std::size_t kAll = 65536;  ///< nodes of models that are looked at as a whole
constexpr std::size_t kRuns = 60, kInRun = 32;

}  // namespace

SampledNodes nodes_for_curvature_noise(const SurfelTree& tree) {
    const std::size_t n = tree.n_nodes();
    SampledNodes sample;
    if (n <= kAll) {
        sample.nodes.resize(std::max<std::size_t>(n, 1) - 1);  // the root has no surface
        std::iota(sample.nodes.begin(), sample.nodes.end(), 1u);
        sample.stand_for.assign(sample.nodes.size(), 1);
        return sample;
    }
    // Part k of kRuns begins at its square: large nodes come first, and have most of the area.
    const auto begin_of = [&](std::size_t k) { return 1 + (n - 1) * k * k / (kRuns * kRuns); };
    for (std::size_t k = 0; k < kRuns; ++k) {
        const std::size_t begin = begin_of(k), n_part = begin_of(k + 1) - begin;
        const std::size_t n_taken = std::min(n_part, kInRun);
        for (std::size_t i = begin; i < begin + n_taken; ++i) {
            sample.nodes.push_back(static_cast<std::uint32_t>(i));
            sample.stand_for.push_back(static_cast<double>(n_part) / static_cast<double>(n_taken));
        }
    }
    return sample;
}

double curvature_noise(const SurfelTree& tree, const SampledNodes& sample) {
    std::vector<std::pair<double, double>> leaves;  // curvature, area
    double area = 0;
    for (std::size_t k = 0; k < sample.nodes.size(); ++k) {
        const TreeNode& node = tree.node(sample.nodes[k]);
        if (!node.is_leaf() || node.n_points == 0) continue;
        // The ball that bounds a leaf is its own.
        const double sq_radius =
            static_cast<double>(node.bound_radius) * static_cast<double>(node.bound_radius);
        const double curvature = kTimes * static_cast<double>(node.fit_error) /
                                 (sq_radius * std::sqrt(static_cast<double>(node.n_points)));
        if (!std::isfinite(curvature)) continue;
        leaves.emplace_back(curvature, sq_radius * sample.stand_for[k]);
        area += leaves.back().second;
    }
    std::sort(leaves.begin(), leaves.end());
    double below = 0;
    for (const auto& [curvature, own] : leaves)
        if ((below += own) >= area / 2) return curvature;
    return 0;
}

}  // namespace slim
