#include "slim/tree/leaf_pieces.h"

#include "slim/neighbors/morton.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace slim {
namespace {

/// Large leaves first, octave by octave: boxes of neighbours are then of like size. 57 bits of
/// place.
std::uint64_t order_key(const MortonCurve& curve, const Vec3d& center, double radius) {
    const int octave = std::clamp(std::ilogb(radius) + 64, 0, 127);
    return static_cast<std::uint64_t>(127 - octave) << 57 | curve.key(center) >> 6;
}

}  // namespace

LeafPieces::LeafPieces(const SurfelTree& tree) : tree_(tree) {
    order_leaves();
    boxes_ = BoxTree(size(), [&](std::size_t leaf) {
        const Vec3d c = to_double(balls_[leaf].center);
        const double r = double{balls_[leaf].radius};
        return Bbox{c - Vec3d{r, r, r}, c + Vec3d{r, r, r}};
    });
    pieces_ = JoinedSets(size());
    join_what_agrees();
}

void LeafPieces::order_leaves() {
    Bbox box;
    std::size_t n = 0;
    for (std::size_t i = 0; i < tree_.n_nodes(); ++i) {
        if (!tree_.node(i).is_leaf()) continue;
        box.extend(tree_.center(i));
        ++n;
    }
    const MortonCurve curve(box);
    std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
    order.reserve(n);
    for (std::uint32_t i = 0; i < tree_.n_nodes(); ++i)
        if (tree_.node(i).is_leaf())
            order.emplace_back(order_key(curve, tree_.center(i), tree_.support_radius(i)), i);
    std::sort(order.begin(), order.end());
    node_.resize(n);
    std::transform(order.begin(), order.end(), node_.begin(),
                   [](const auto& e) { return e.second; });
    std::vector<std::pair<std::uint64_t, std::uint32_t>>().swap(order);
    balls_.resize(n);
    for (std::size_t i = 0; i < n; ++i)
        balls_[i] = {to_float(tree_.center(node_[i]) - box.center()),
                     static_cast<float>(support_radius(i))};
}

void LeafPieces::join_what_agrees() {
    const auto find = [&](std::size_t leaf, std::vector<Link>& links) {
        const auto i = static_cast<std::uint32_t>(leaf);
        const LeafSamples samples(tree_.surfel(node_[i]));
        for_overlapping(i, [&](std::uint32_t j) {
            if (is_smaller(i, j) && agrees(samples, tree_, node_[j]))
                links.push_back({i, j, Meeting::agree});
        });
    };
    // Which piece a leaf is of does not depend on the order of the links.
    in_rounds(size(), find, [&](const Link& link) { join(link.leaf, link.other); });
}

void LeafPieces::add_links(std::uint32_t i, std::vector<Link>& links) const {
    const LeafSamples samples(tree_.surfel(node_[i]));
    for_overlapping(i, [&](std::uint32_t j) {
        const Meeting meeting =
            is_smaller(i, j) ? meeting_of(samples, tree_, node_[j])
                             : meeting_of(LeafSamples(tree_.surfel(node_[j])), tree_, node_[i]);
        if (meeting != Meeting::apart) links.push_back({i, j, meeting});
    });
}

}  // namespace slim
