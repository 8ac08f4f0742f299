#include "slim/tree/drawn_beyond.h"

#include "slim/tree/leaf_places.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace slim {
namespace {

constexpr double kVisible = 0.02;

/// The longer side that a view along the longest axis of a box shows.
double middle_extent(const Bbox& box) {
    const Vec3d e = box.extent();
    return std::max(std::min(e.x, e.y), std::min(std::max(e.x, e.y), e.z));
}

Bbox grown(const Bbox& box, double by) {
    const Vec3d all{by, by, by};
    return {box.lo - all, box.hi + all};
}

bool holds(const Bbox& box, const Vec3d& center, double radius) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (!(box.lo[axis] <= center[axis] - radius && center[axis] + radius <= box.hi[axis]))
            return false;
    return true;
}

/// Places of the leaves that leave a box.
std::vector<Vec3d> places_of_leaving(const SurfelTree& tree, bool loose, const Bbox& box) {
    std::vector<Vec3d> out;
    std::vector<LeafPlace> places;
    for (std::size_t i = 0; i < tree.n_nodes(); ++i) {
        const TreeNode& node = tree.node(i);
        if (!node.is_leaf() || (node.is_loose() && !loose)) continue;
        if (holds(box, tree.center(i), radius_of_places(tree, i))) continue;
        places.clear();
        append_close_places(tree.surfel(i), places);
        const bool leaves = std::any_of(places.begin(), places.end(), [&](const LeafPlace& p) {
            return !holds(box, p.position, 0);
        });
        if (!leaves) continue;
        for (const LeafPlace& place : places) out.push_back(place.position);
    }
    return out;
}

}  // namespace

BeyondBox drawn_beyond(const SurfelTree& tree, bool loose, const Bbox& drawn) {
    if (drawn.empty()) return {drawn, {}};
    const Bbox seen = grown(drawn, kVisible * middle_extent(drawn));
    BeyondBox out{drawn, places_of_leaving(tree, loose, seen)};
    Bbox all;
    for (const Vec3d& place : out.places) all.extend(place);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (all.lo[axis] < seen.lo[axis]) out.box.lo[axis] = all.lo[axis];
        if (all.hi[axis] > seen.hi[axis]) out.box.hi[axis] = all.hi[axis];
    }
    return out;
}

}  // namespace slim
