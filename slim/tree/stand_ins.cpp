#include "slim/tree/stand_ins.h"

#include "slim/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace slim {
namespace {

constexpr std::uint32_t kLeastChildren = 8;
constexpr double kMostError = 1.0 / 32;  // of the radius
constexpr double kSameNormal = 0.94;     // cosine of 20 degrees
constexpr double kNearRadius = 0.5, kFarRadius = 0.95;
constexpr int kNear = 6, kFar = 12;

struct Place {
    Vec3d position, normal;
};

/// Whether some leaf holds the place and is of the same surface there.
class LeafWalk {
public:
    explicit LeafWalk(const SurfelTree& tree) : tree_(tree) {}

    bool finds(const Place& place) {
        stack_.assign(1, 0);
        while (!stack_.empty()) {
            const TreeNode& node = tree_.node(stack_.back());
            stack_.pop_back();
            for (std::uint32_t c = 0; c < node.n_children; ++c) {
                const std::uint32_t child = node.first_child + c;
                const TreeNode& below = tree_.node(child);
                const auto bound = static_cast<double>(below.bound_radius);
                if (sq_length(place.position - tree_.center(child)) >= bound * bound) continue;
                if (!below.is_leaf()) stack_.push_back(child);
                else if (agrees(child, place))
                    return true;
            }
        }
        return false;
    }

private:
    bool agrees(std::uint32_t leaf, const Place& place) const {
        const TreeNode& node = tree_.node(leaf);
        if (node.is_loose() || (node.flags & kSharp) || node.rims().any()) return false;
        const Surfel s = tree_.surfel(leaf);
        const Vec3d x = (place.position - s.center) / s.support_radius;
        if (!(sq_length(x) < 1)) return false;
        const Vec3d gradient = s.sheet_gradient(0, x);
        const double steepness = length(gradient);
        return std::abs(s.value(x)) < kBelongs * steepness &&
               dot(gradient, place.normal) > kSameNormal * steepness;
    }

    const SurfelTree& tree_;
    std::vector<std::uint32_t> stack_;
};

Place place_on(const Surfel& s, double radius, double angle) {
    const double u = radius * std::cos(angle), v = radius * std::sin(angle);
    const Vec3d x = s.frame.world_from_local({u, v, s.polynomial.value(u, v)});
    return {s.center + x * s.support_radius, normalized(s.sheet_gradient(0, x))};
}

bool agree_all_over(const Surfel& s, LeafWalk& leaves) {
    const auto ring = [&](double radius, int n) {
        for (int k = 0; k < n; ++k)
            if (!leaves.finds(place_on(s, radius, 2 * std::numbers::pi * k / n))) return false;
        return true;
    };
    return ring(kFarRadius, kFar) && ring(kNearRadius, kNear) && ring(0, 1);
}

bool may_stand_in(const SurfelTree& tree, std::size_t i) {
    const TreeNode& node = tree.node(i);
    return i > 0 && !node.is_leaf() && !node.is_loose() && !(node.flags & kSharp) &&
           node.n_children >= kLeastChildren &&
           node.fit_error <= kMostError * tree.support_radius(i);
}

}  // namespace

std::uint64_t mark_stand_ins(SurfelTreeData& tree) {
    const SurfelTree view = tree.view();
    std::vector<char> marked(view.n_nodes(), 0);
    constexpr std::size_t kGrain = 256;
    parallel_blocks(view.n_nodes(), kGrain, [&](std::size_t begin, std::size_t end) {
        LeafWalk leaves(view);
        for (std::size_t i = begin; i < end; ++i)
            marked[i] = may_stand_in(view, i) && agree_all_over(view.surfel(i), leaves);
    });
    for (std::size_t i = 0; i < marked.size(); ++i)
        if (marked[i]) tree.nodes[i].flags |= kStandsIn;
    return static_cast<std::uint64_t>(std::count(marked.begin(), marked.end(), 1));
}

}  // namespace slim
