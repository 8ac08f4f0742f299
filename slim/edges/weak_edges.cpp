#include "slim/edges/weak_edges.h"

#include <algorithm>
#include <numbers>

namespace slim {
namespace {

constexpr double kTurnOverRoughness = 12;
constexpr double kSurelyTurns = std::numbers::pi / 4;

/// Mean angle by which the normal turns, radians.
double mean_turn(const SharpEdge& edge) {
    double sum = 0;
    for (const EdgePoint& p : edge.points) sum += static_cast<double>(p.turn_deg());
    return sum / static_cast<double>(edge.points.size()) * std::numbers::pi / 180;
}

}  // namespace

double sharp_roughness(const SurfelTree& tree, bool loose) {
    std::vector<float> rough;
    for (const SharpEntry& entry : tree.sharp()) {
        const TreeNode& node = tree.node(entry.node);
        if (!node.is_leaf() || (node.is_loose() && !loose)) continue;
        rough.push_back(node.fit_error /
                        static_cast<float>(tree.surfel(entry.node).support_radius));
    }
    if (rough.empty()) return 0;
    const auto middle = rough.begin() + static_cast<std::ptrdiff_t>(rough.size() / 2);
    std::nth_element(rough.begin(), middle, rough.end());
    return static_cast<double>(*middle);
}

std::vector<SharpEdge> without_weak_edges(std::vector<SharpEdge> edges, double roughness) {
    const double least = std::min(kTurnOverRoughness * roughness, kSurelyTurns);
    std::erase_if(
        edges, [&](const SharpEdge& edge) { return edge.n_leaves < 2 && mean_turn(edge) < least; });
    return edges;
}

}  // namespace slim
