#include "slim/tree/ball_index.h"

#include "slim/neighbors/morton.h"

#include <algorithm>
#include <utility>

namespace slim {
namespace {

bool contains(const Bbox& b, const Vec3d& p) {
    return p.x >= b.lo.x && p.x <= b.hi.x && p.y >= b.lo.y && p.y <= b.hi.y && p.z >= b.lo.z &&
           p.z <= b.hi.z;
}

Bbox box_of(const Surfel& s) {
    const Vec3d r{s.support_radius, s.support_radius, s.support_radius};
    Bbox b;
    b.extend(s.center - r);
    b.extend(s.center + r);
    return b;
}

}  // namespace

BallIndex::BallIndex(const SurfelTree& tree) {
    Bbox box;
    for (std::size_t i = 0; i < tree.n_nodes(); ++i)
        if (tree.node(i).is_leaf()) box.extend(tree.center(i));
    const MortonCurve curve(box);
    std::vector<std::pair<std::uint64_t, std::size_t>> order;
    for (std::size_t i = 0; i < tree.n_nodes(); ++i)
        if (tree.node(i).is_leaf()) order.emplace_back(curve.key(tree.center(i)), i);
    std::sort(order.begin(), order.end());
    leaves_.reserve(order.size());
    std::vector<Bbox> boxes;
    for (const auto& [key, node] : order) {
        leaves_.push_back(tree.surfel(node));
        boxes.push_back(box_of(leaves_.back()));
    }
    levels_.push_back(std::move(boxes));
    while (levels_.back().size() > kFanout) {
        std::vector<Bbox> above((levels_.back().size() + kFanout - 1) / kFanout);
        for (std::size_t i = 0; i < levels_.back().size(); ++i)
            above[i / kFanout].extend(levels_.back()[i]);
        levels_.push_back(std::move(above));
    }
}

void BallIndex::supporters(const Vec3d& p, std::vector<const Surfel*>& out) const {
    out.clear();
    struct Entry {
        std::size_t level, index;
    };
    Entry stack[128];
    std::size_t depth = 0;
    for (std::size_t i = levels_.back().size(); i-- > 0;) stack[depth++] = {levels_.size() - 1, i};
    while (depth > 0) {
        const Entry e = stack[--depth];
        if (!contains(levels_[e.level][e.index], p)) continue;
        if (e.level == 0) {
            const Surfel& s = leaves_[e.index];
            if (sq_length(p - s.center) < s.support_radius * s.support_radius) out.push_back(&s);
            continue;
        }
        const std::size_t first = e.index * kFanout;
        const std::size_t last = std::min(first + kFanout, levels_[e.level - 1].size());
        for (std::size_t c = last; c-- > first;) stack[depth++] = {e.level - 1, c};
    }
}

}  // namespace slim
