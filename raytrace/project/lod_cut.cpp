#include "raytrace/project/lod_cut.h"

#include "slim/base/error.h"

#include <cmath>
#include <limits>
#include <string>

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

bool ViewVolume::may_see(const Vec3d& center, double radius) const {
    for (const Plane& p : planes_)
        if (dot(p.normal, center) + p.offset < -radius) return false;
    return true;
}

double projected_diameter(const PixelView& view, const Vec3d& center, double radius) {
    if (view.orthographic) return 2 * radius * view.px_per_unit;
    const double distance = length(center);
    if (distance <= radius) return std::numeric_limits<double>::infinity();
    return 2 * radius * view.focal_px / distance;
}

std::vector<std::uint32_t> lod_cut(const SurfelTree& tree, const PixelView& view,
                                   const PixelWindow& window, const CutRules& rules,
                                   CutCounts& counts) {
    std::vector<std::uint32_t> cut;
    if (tree.n_nodes() == 0) return cut;
    const ViewVolume volume(view, window);
    std::vector<std::uint32_t> stack{0};
    for (std::size_t n_met = 1; !stack.empty(); ++n_met) {
        const std::uint32_t i = stack.back();
        stack.pop_back();
        if (n_met > tree.n_nodes())
            throw FormatError("tree node " + std::to_string(i) + ": has another parent too");
        ++counts.nodes_visited;
        if (counts.visited) counts.visited->push_back(i);
        const TreeNode& node = tree.node(i);
        const Vec3d center = view.camera_from_local(tree.center(i));
        const double radius = tree.support_radius(i);
        if (!volume.may_see(center, std::max<double>(node.bound_radius, radius))) continue;
        const bool small = i != 0 && projected_diameter(view, center, radius) <= rules.lod_px;
        if (node.is_leaf() || (small && node.n_children > 0)) {
            if (!volume.may_see(center, radius)) continue;
            if (rules.loose || !node.is_loose()) cut.push_back(i);
            else
                ++counts.loose_hidden;
            continue;
        }
        if (node.n_children == 0) continue;
        check_children(tree, i);
        for (std::uint32_t c = node.n_children; c-- > 0;) stack.push_back(node.first_child + c);
    }
    return cut;
}

}  // namespace slim
