#include "pipeline/render/curvature_noise.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace slim {
namespace {

constexpr double kTimes = 140;
constexpr std::size_t kMost = 65536;  ///< nodes that are looked at

}  // namespace

double curvature_noise(const SurfelTree& tree) {
    std::vector<std::pair<double, double>> leaves;  // curvature, area
    double area = 0;
    const std::size_t step = 1 + tree.n_nodes() / kMost;
    for (std::size_t i = 1; i < tree.n_nodes(); i += step) {
        const TreeNode& node = tree.node(i);
        if (!node.is_leaf() || node.n_points == 0) continue;
        // The ball that bounds a leaf is its own.
        const double sq_radius =
            static_cast<double>(node.bound_radius) * static_cast<double>(node.bound_radius);
        const double curvature = kTimes * static_cast<double>(node.fit_error) /
                                 (sq_radius * std::sqrt(static_cast<double>(node.n_points)));
        if (!std::isfinite(curvature)) continue;
        leaves.emplace_back(curvature, sq_radius);
        area += sq_radius;
    }
    std::sort(leaves.begin(), leaves.end());
    double below = 0;
    for (const auto& [curvature, own] : leaves)
        if ((below += own) >= area / 2) return curvature;
    return 0;
}

}  // namespace slim
