#include "raytrace/project/lod_cut.h"

#include "slim/base/error.h"
#include "slim/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
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
    if (center.z <= radius) return std::numeric_limits<double>::infinity();
    // As it stands askew to the picture: 1 / cos^2 of the angle off the axis.
    return 2 * radius * view.focal_px * length(center) / (center.z * center.z);
}

namespace {

/// Over its radius: an internal surfel whose subtree reaches farther stands in for nothing. Where
/// balls hold their children none does (2.7 at most, slim/tree/notes/0009); trees of before hang
/// some leaves on balls far away.
constexpr double kFarthestHeld = 5;

/// Whether an internal surfel is drawn for all below it: one of at most lod_px in diameter, or one
/// that kStandsIn says it of, up to three levels larger, where its children have less than
/// (lod_px / 2)^2 of its disc each and its error is below lod_px / 64. A leaf may be three levels
/// finer than the ball above it.
bool is_enough(const PixelView& view, const TreeNode& node, const Vec3d& center, double radius,
               double lod_px) {
    if (node.n_children == 0) return false;
    if (static_cast<double>(node.bound_radius) > kFarthestHeld * radius) return false;
    constexpr double kLevels = 4.236;  // the ratio of radii
    const double most = node.flags & kStandsIn ? kLevels * lod_px : lod_px;
    // Most are far larger: no root and no division for them, as on the axis.
    if (!view.orthographic && 2 * radius * view.focal_px > most * std::abs(center.z)) return false;
    const double diameter = projected_diameter(view, center, radius);
    if (diameter <= lod_px) return true;
    if (diameter > most) return false;
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

/// Nodes side by side, children of one parent or of some; `within`: all of their parents' balls are
/// seen, so that nothing below needs a test of the volume.
struct Family {
    std::uint32_t first, n;
    bool within;
};

/// At the end of others, of which it may go on: less to step through than each parent's own.
void add_family(const Family& family, std::vector<Family>& families) {
    constexpr std::uint32_t kMost = 256;
    if (!families.empty()) {
        Family& last = families.back();
        if (last.first + last.n == family.first && last.within == family.within &&
            last.n + family.n <= kMost) {
            last.n += family.n;
            return;
        }
    }
    families.push_back(family);
}

/// What some families add to the cut, and those below them.
struct CutPart {
    std::vector<std::uint32_t> cut, visited;  ///< visited: only if asked for
    std::vector<Family> below;
    std::uint64_t loose_hidden = 0;
};

/// A generation after the other, in the order in which files hold them: nodes and records that are
/// read follow each other.
class CutWalk {
public:
    CutWalk(const SurfelTree& tree, const PixelView& view, const ViewVolume& volume,
            const CutRules& rules, bool keep_visited)
        : tree_(tree), view_(view), volume_(volume), rules_(rules), keep_visited_(keep_visited) {}

    void take_families(std::span<const Family> families, CutPart& out) const {
        for (const Family& family : families)
            for (std::uint32_t i = family.first; i < family.first + family.n; ++i) {
                if (keep_visited_) out.visited.push_back(i);
                if (family.within && tree_.node(i).is_leaf()) take(i, out);
                else
                    enter(i, family.within, out);
            }
    }

private:
    /// Takes a node to the cut, or its children to what is to be entered.
    void enter(std::uint32_t i, bool within, CutPart& out) const {
        const TreeNode& node = tree_.node(i);
        const Vec3d center = view_.camera_from_local(tree_.center(i));
        const double radius = tree_.support_radius(i);
        const double depth =
            within ? std::numeric_limits<double>::infinity() : volume_.depth_within(center);
        const double all_below = std::max<double>(node.bound_radius, radius);
        if (depth < -all_below) return;
        if (node.is_leaf() || (i != 0 && is_enough(view_, node, center, radius, rules_.lod_px))) {
            if (depth >= -radius) take(i, out);
            return;
        }
        if (node.n_children == 0) return;
        check_children(tree_, i);
        add_family({node.first_child, node.n_children, depth >= all_below}, out.below);
    }
    void take(std::uint32_t i, CutPart& out) const {
        if (rules_.loose || !tree_.node(i).is_loose()) out.cut.push_back(i);
        else
            ++out.loose_hidden;
    }

    const SurfelTree& tree_;
    const PixelView& view_;
    const ViewVolume& volume_;
    const CutRules& rules_;
    bool keep_visited_;
};

template <class T>
void append(const std::vector<T>& more, std::vector<T>& to) {
    to.insert(to.end(), more.begin(), more.end());
}

/// What a generation of n nodes adds, in its order: large ones in parallel.
CutPart generation(const CutWalk& walk, std::span<const Family> families, std::uint64_t n) {
    constexpr std::size_t kGrain = 8, kFewNodes = 2048;
    CutPart all;
    if (n <= kFewNodes) {
        walk.take_families(families, all);
        return all;
    }
    std::vector<CutPart> parts((families.size() + kGrain - 1) / kGrain);
    parallel_blocks(families.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        walk.take_families(families.subspan(begin, end - begin), parts[begin / kGrain]);
    });
    for (const CutPart& part : parts) {
        append(part.cut, all.cut), append(part.visited, all.visited);
        append(part.below, all.below);
        all.loose_hidden += part.loose_hidden;
    }
    return all;
}

/// Some node is a child twice: says which.
[[noreturn]] void throw_shared(const SurfelTree& tree) {
    std::vector<bool> is_child(tree.n_nodes(), false);
    for (std::uint32_t i = 0; i < tree.n_nodes(); ++i) {
        const TreeNode& node = tree.node(i);
        if (node.n_children == 0) continue;
        check_children(tree, i);
        for (std::uint32_t c = node.first_child; c < node.first_child + node.n_children; ++c) {
            if (is_child[c])
                throw FormatError("tree node " + std::to_string(c) + ": has another parent too");
            is_child[c] = true;
        }
    }
    throw FormatError("tree nodes: met more often than there are");
}

}  // namespace

std::vector<std::uint32_t> lod_cut(const SurfelTree& tree, const PixelView& view,
                                   const PixelWindow& window, const CutRules& rules,
                                   CutCounts& counts) {
    std::vector<std::uint32_t> cut;
    if (tree.n_nodes() == 0) return cut;
    const ViewVolume volume(view, with_margin(view, window, rules.lod_px));
    const CutWalk walk(tree, view, volume, rules, counts.visited != nullptr);
    std::uint64_t visited = 0;
    for (std::vector<Family> families{{0, 1, false}}; !families.empty();) {
        std::uint64_t n = 0;
        for (const Family& family : families) n += family.n;
        visited += n;
        if (visited > tree.n_nodes()) throw_shared(tree);
        CutPart part = generation(walk, families, n);
        append(part.cut, cut);
        counts.loose_hidden += part.loose_hidden;
        if (counts.visited) append(part.visited, *counts.visited);
        families = std::move(part.below);
    }
    counts.nodes_visited += visited;
    return cut;
}

}  // namespace slim
