#include "raytrace/project/lod_cut.h"

#include "slim/base/error.h"
#include "slim/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

namespace slim {
namespace {

void check_children(const SurfelTree& tree, std::uint32_t i) {
    const TreeNode& node = tree.node(i);
    if (node.first_child > i && node.first_child < tree.n_nodes() &&
        node.n_children <= tree.n_nodes() - node.first_child)
        return;
    throw FormatError("tree node " + std::to_string(i) + ": children [" +
                      std::to_string(node.first_child) + ", +" + std::to_string(node.n_children) +
                      ") must follow it inside a tree of " + std::to_string(tree.n_nodes()) +
                      " nodes");
}

}  // namespace

ViewVolume::ViewVolume(const PixelView& view, const PixelWindow& window) {
    const double scale = view.orthographic ? view.px_per_unit : view.focal_px;
    const double left = (window.x - view.center_x) / scale;
    const double right = (window.x + window.width - view.center_x) / scale;
    const double top = (window.y - view.center_y) / scale;
    const double bottom = (window.y + window.height - view.center_y) / scale;
    const auto side = [&](double x, double y, double bound) {
        // Orthographic: x - bound >= 0; perspective: x - bound z >= 0.
        if (view.orthographic) return Plane{{x, y, 0}, -bound};
        const Vec3d normal{x, y, -bound};
        return Plane{normalized(normal), 0};
    };
    planes_[0] = side(1, 0, left);
    planes_[1] = side(-1, 0, -right);
    planes_[2] = side(0, 1, top);
    planes_[3] = side(0, -1, -bottom);
    planes_[4] = {{0, 0, 1}, -view.near_plane};
}

double ViewVolume::depth_within(const Vec3d& center) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Plane& p : planes_) least = std::min(least, dot(p.normal, center) + p.offset);
    return least;
}

double projected_diameter(const PixelView& view, const Vec3d& center, double radius) {
    if (view.orthographic) return 2 * radius * view.px_per_unit;
    const double distance = length(center);
    if (distance <= radius) return std::numeric_limits<double>::infinity();
    return 2 * radius * view.focal_px / distance;
}

namespace {

/// Whether an internal surfel of that radius and diameter in pixels is drawn for all below it: one
/// of at most lod_px, or one that kStandsIn says it of, up to three levels larger, where its
/// children have less than (lod_px / 2)^2 of its disc each and its error is below lod_px / 64. A
/// leaf may be three levels finer than the ball above it.
bool is_enough(const TreeNode& node, double radius, double diameter, double lod_px) {
    if (node.n_children == 0) return false;
    if (diameter <= lod_px) return true;
    constexpr double kLevels = 4.236;  // the ratio of radii
    if (!(node.flags & kStandsIn) || diameter > kLevels * lod_px) return false;
    const double disc = std::numbers::pi / 4 * diameter * diameter;
    const double error = static_cast<double>(node.fit_error) / (2 * radius) * diameter;
    return disc < node.n_children * lod_px * lod_px / 4 && error < lod_px / 64;
}

/// The window with a margin for what stands in, which is drawn in a larger ball than its own
/// (stand_in): subtrees are left out by the balls in them. It sticks out by less than lod_px,
/// turned by the tilt of the ray to the picture's corner.
PixelWindow with_margin(const PixelView& view, PixelWindow w, double lod_px) {
    const auto farthest = [](double center, int begin, int n) {
        return std::max(std::abs(begin - center), std::abs(begin + n - center));
    };
    const double x = farthest(view.center_x, w.x, w.width),
                 y = farthest(view.center_y, w.y, w.height);
    const double tilt = view.orthographic ? 0 : (x * x + y * y) / (view.focal_px * view.focal_px);
    const int margin = static_cast<int>(std::min(std::ceil(lod_px * (1 + tilt)), 1e6));
    return {w.x - margin, w.y - margin, w.width + 2 * margin, w.height + 2 * margin};
}

/// Walks down from some nodes.
class CutWalk {
public:
    CutWalk(const SurfelTree& tree, const PixelView& view, const ViewVolume& volume,
            const CutRules& rules, bool keep_visited)
        : tree_(tree), view_(view), volume_(volume), rules_(rules), keep_visited_(keep_visited) {}

    std::vector<std::uint32_t> cut, visited;  ///< visited: only if asked for
    std::uint64_t n_visited = 0, loose_hidden = 0;

    const SurfelTree& tree() const { return tree_; }

    /// A node to enter; `within`: all of its parent's ball is seen,
    /// so that no test of the volume is needed.
    struct Node {
        std::uint32_t index;
        bool within;
    };
    /// All below a node and itself, depth first.
    void walk(Node root) {
        std::vector<Node> stack{root};
        while (!stack.empty()) {
            Node n = stack.back();
            stack.pop_back();
            const TreeNode& node = tree_.node(n.index);
            if (enters(n))
                for (std::uint32_t c = node.n_children; c-- > 0;)
                    stack.push_back({node.first_child + c, n.within});
        }
    }
    /// Takes a node to the cut, or says whether to go on to its children,
    /// and whether those are within.
    bool enters(Node& n) {
        const std::uint32_t i = n.index;
        if (n_visited >= tree_.n_nodes())
            throw FormatError("tree node " + std::to_string(i) + ": has another parent too");
        ++n_visited;
        if (keep_visited_) visited.push_back(i);
        const TreeNode& node = tree_.node(i);
        if (n.within && node.is_leaf()) return take(i), false;
        const Vec3d center = view_.camera_from_local(tree_.center(i));
        const double radius = tree_.support_radius(i);
        const double depth =
            n.within ? std::numeric_limits<double>::infinity() : volume_.depth_within(center);
        const double all_below = std::max<double>(node.bound_radius, radius);
        if (depth < -all_below) return false;
        if (node.is_leaf() ||
            (i != 0 &&
             is_enough(node, radius, projected_diameter(view_, center, radius), rules_.lod_px))) {
            if (depth >= -radius) take(i);
            return false;
        }
        if (node.n_children == 0) return false;
        check_children(tree_, i);
        n.within = depth >= all_below;
        return true;
    }

private:
    void take(std::uint32_t i) {
        if (rules_.loose || !tree_.node(i).is_loose()) cut.push_back(i);
        else
            ++loose_hidden;
    }

    const SurfelTree& tree_;
    const PixelView& view_;
    const ViewVolume& volume_;
    const CutRules& rules_;
    bool keep_visited_;
};

/// A part of the walk in its place of the order: ended, or with a node that is still to be entered.
struct Branch {
    CutWalk walk;
    std::optional<CutWalk::Node> node;
};

/// The root's, level by level until they are many.
std::vector<Branch> branches_of(const CutWalk& none) {
    constexpr std::size_t kMany = 64;
    constexpr int kDeepest = 12;
    std::vector<Branch> branches{{none, CutWalk::Node{0, false}}};
    for (int level = 0; level < kDeepest && branches.size() < kMany; ++level) {
        std::vector<Branch> below;
        bool deeper = false;
        for (Branch& b : branches) {
            if (!b.node) {
                below.push_back(std::move(b));
                continue;
            }
            CutWalk::Node n = *b.node;
            const TreeNode& node = none.tree().node(n.index);
            const bool enters = b.walk.enters(n);
            below.push_back({std::move(b.walk), std::nullopt});
            for (std::uint32_t c = 0; enters && c < node.n_children; ++c)
                below.push_back({none, CutWalk::Node{node.first_child + c, n.within}});
            deeper = deeper || enters;
        }
        branches = std::move(below);
        if (!deeper) break;
    }
    return branches;
}

}  // namespace

std::vector<std::uint32_t> lod_cut(const SurfelTree& tree, const PixelView& view,
                                   const PixelWindow& window, const CutRules& rules,
                                   CutCounts& counts) {
    std::vector<std::uint32_t> cut;
    if (tree.n_nodes() == 0) return cut;
    const ViewVolume volume(view, with_margin(view, window, rules.lod_px));
    const CutWalk none(tree, view, volume, rules, counts.visited != nullptr);
    std::vector<Branch> branches = branches_of(none);
    parallel_blocks(branches.size(), 1, [&](std::size_t k, std::size_t) {
        if (branches[k].node) branches[k].walk.walk(*branches[k].node);
    });
    std::uint64_t visited = 0;
    for (const Branch& b : branches) visited += b.walk.n_visited;
    if (visited > tree.n_nodes()) CutWalk(none).walk({0, false});  // says which node is met twice
    counts.nodes_visited += visited;
    for (const Branch& b : branches) {
        const CutWalk& walk = b.walk;
        cut.insert(cut.end(), walk.cut.begin(), walk.cut.end());
        counts.loose_hidden += walk.loose_hidden;
        if (counts.visited)
            counts.visited->insert(counts.visited->end(), walk.visited.begin(), walk.visited.end());
    }
    return cut;
}

}  // namespace slim
