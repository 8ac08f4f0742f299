#include "slim/tree/drawn_limits.h"

#include "slim/base/parallel.h"
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

/// The box of the places of all leaves that may leave a box.
Bbox box_of_leaving(const SurfelTree& tree, bool loose, const Bbox& box) {
    constexpr std::size_t kGrain = 4096;
    std::vector<Bbox> parts((tree.n_nodes() + kGrain - 1) / kGrain);
    parallel_blocks(tree.n_nodes(), kGrain, [&](std::size_t begin, std::size_t end) {
        std::vector<LeafPlace> places;
        for (std::size_t i = begin; i < end; ++i) {
            const TreeNode& node = tree.node(i);
            if (!node.is_leaf() || (node.is_loose() && !loose)) continue;
            if (holds(box, tree.center(i), radius_of_places(tree, i))) continue;
            append_places(tree.surfel(i), places);
        }
        for (const LeafPlace& place : places) parts[begin / kGrain].extend(place.position);
    });
    Bbox all;
    for (const Bbox& part : parts) all.extend(part);
    return all;
}

}  // namespace

Bbox drawn_limits(const SurfelTree& tree, bool loose) {
    Bbox limits = tree.header().bounds;
    if (limits.empty()) return limits;
    const Bbox seen = grown(limits, kVisible * middle_extent(limits));
    const Bbox leaving = box_of_leaving(tree, loose, seen);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (leaving.lo[axis] < seen.lo[axis]) limits.lo[axis] = leaving.lo[axis];
        if (leaving.hi[axis] > seen.hi[axis]) limits.hi[axis] = leaving.hi[axis];
    }
    return limits;
}

}  // namespace slim
