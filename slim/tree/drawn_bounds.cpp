#include "slim/tree/drawn_bounds.h"

#include "slim/base/common_box.h"
#include "slim/base/error.h"
#include "slim/base/parallel.h"
#include "slim/tree/drawn_hull.h"
#include "slim/tree/leaf_places.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>

namespace slim {
namespace {

/// How far what is drawn of a leaf, and the points that it covers, reach from its centre along each
/// axis: a disc across the normal with the heights of its polynomial and its points, and no farther
/// than the core.
Vec3d reach_of(const Surfel& s, double residual) {
    const double core = kHitTrim * s.support_radius;
    if (s.sharp) return {core, core, core};
    const double height = s.support_radius * most_height(s.polynomial, kHitTrim) + residual;
    Vec3d reach;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double along = std::abs(s.frame.normal[axis]);
        const double across = std::sqrt(std::max(0.0, 1 - along * along));
        reach[axis] = std::min(core, across * core + along * height);
    }
    return reach;
}

Bbox box_about(const Vec3d& center, const Vec3d& reach) {
    Bbox box;
    box.extend(center - reach);
    box.extend(center + reach);
    return box;
}

/// One of six: up or down an axis.
struct Direction {
    std::size_t axis;
    double sign;

    double along(const Vec3d& p) const { return sign * p[axis]; }
    double most(const Bbox& box) const { return sign > 0 ? box.hi[axis] : -box.lo[axis]; }
};

/// Boxes of leaves' cores.
class LeafBoxes {
public:
    explicit LeafBoxes(const SurfelTree& tree)
        : tree_(tree), noise_(std::sqrt(tree.header().noise_variance)) {}

    Bbox whole(std::uint32_t i) const {
        const Surfel s = tree_.surfel(i);
        // A covered point is no farther from the leaf (slim/cover).
        const double residual = 4 * std::max<double>(tree_.node(i).fit_error, noise_);
        return box_about(s.center, reach_of(s, residual));
    }
    /// Where points are; empty if none are.
    Bbox shown(std::uint32_t i) const { return common(whole(i), tree_.header().bounds); }

private:
    const SurfelTree& tree_;
    double noise_;
};

class Search {
public:
    Search(const SurfelTree& tree, bool loose, std::vector<std::uint32_t>* visited)
        : tree_(tree),
          loose_(loose),
          visited_(visited),
          points_(tree.header().bounds),
          boxes_(tree) {}

    /// Widens the box as far as anything reaches in a direction: what may reach farthest first.
    void widen(const Direction& d) {
        std::vector<Candidate> heap;
        push(0, d, heap);
        for (std::size_t n_met = 0; !heap.empty(); ++n_met) {
            const Candidate next = heap.front();
            if (!box_.empty() && next.reach <= d.most(box_)) return;
            std::pop_heap(heap.begin(), heap.end());
            heap.pop_back();
            const TreeNode& node = tree_.node(next.node);
            check_children(next.node, n_met);
            if (node.is_leaf()) box_.extend(boxes_.shown(next.node));
            for (std::uint32_t c = 0; c < node.n_children; ++c) push(node.first_child + c, d, heap);
        }
    }
    const Bbox& box() const { return box_; }

private:
    /// Of those that may reach as far the one whose middle lies farthest:
    /// a leaf there ends the search.
    struct Candidate {
        double reach, middle;
        std::uint32_t node;
        bool operator<(const Candidate& other) const {
            return std::tie(reach, middle, other.node) < std::tie(other.reach, other.middle, node);
        }
    };

    void push(std::uint32_t i, const Direction& d, std::vector<Candidate>& heap) const {
        const TreeNode& node = tree_.node(i);
        if (visited_) visited_->push_back(i);
        if (node.is_loose() && !loose_) return;
        const double radius = std::max<double>(node.bound_radius, tree_.support_radius(i));
        const double middle = d.along(tree_.center(i));
        const double reach =
            node.is_leaf() && node.n_children == 0 ? d.most(boxes_.whole(i)) : middle + radius;
        // Where points end counts no more than what is found already.
        heap.push_back({std::min(reach, d.most(points_)), middle, i});
        std::push_heap(heap.begin(), heap.end());
    }

    void check_children(std::uint32_t i, std::size_t n_met) const {
        const TreeNode& node = tree_.node(i);
        const bool in_order =
            node.n_children == 0 || (node.first_child > i && node.first_child < tree_.n_nodes() &&
                                     node.n_children <= tree_.n_nodes() - node.first_child);
        if (n_met >= tree_.n_nodes() || !in_order)
            throw FormatError("tree node " + std::to_string(i) +
                              ": its children are no part of a tree");
    }

    const SurfelTree& tree_;
    bool loose_;
    std::vector<std::uint32_t>* visited_;
    const Bbox& points_;
    LeafBoxes boxes_;
    Bbox box_;
};

}  // namespace

void set_drawn_bounds(SurfelTreeData& data) {
    const SurfelTree tree = data.view();
    const LeafBoxes boxes(tree);
    struct Both {
        Bbox drawn, loose;
    };
    constexpr std::size_t kGrain = 4096;
    std::vector<Both> parts((tree.n_nodes() + kGrain - 1) / kGrain);
    parallel_blocks(tree.n_nodes(), kGrain, [&](std::size_t begin, std::size_t end) {
        Both& part = parts[begin / kGrain];
        for (std::size_t i = begin; i < end; ++i) {
            if (!tree.node(i).is_leaf()) continue;
            const Bbox box = boxes.shown(static_cast<std::uint32_t>(i));
            part.loose.extend(box);
            if (!tree.node(i).is_loose()) part.drawn.extend(box);
        }
    });
    Bbox drawn, loose;
    for (const Both& part : parts) drawn.extend(part.drawn), loose.extend(part.loose);
    const Bbox& points = tree.header().bounds;
    data.header.drawn = drawn.empty() ? points : drawn;
    data.header.drawn_loose = loose.empty() ? points : loose;
    data.header.hull = drawn_hull(tree, false, data.header.drawn);
    data.header.loose_hull = drawn_hull(tree, true, data.header.drawn_loose);
}

Bbox drawn_bounds(const SurfelTree& tree, bool loose, std::vector<std::uint32_t>* visited) {
    const Bbox& known = loose ? tree.header().drawn_loose : tree.header().drawn;
    if (!known.empty()) return known;
    if (tree.n_nodes() == 0) return tree.header().bounds;
    Search search(tree, loose, visited);
    for (const std::size_t axis : {0u, 1u, 2u})
        for (const double sign : {-1.0, 1.0}) search.widen({axis, sign});
    return search.box().empty() ? tree.header().bounds : search.box();
}

}  // namespace slim
