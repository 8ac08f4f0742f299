#include "slim/edges/edge_walk.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr std::size_t kMostPoints = 100'000;

EdgeSide side_of(const Surfel& s, std::size_t pair, const Vec3d& x) {
    const SheetPair& sheets = kSheetPairs[pair];
    return {{normalized(s.sheet_gradient(sheets.a, x)), normalized(s.sheet_gradient(sheets.b, x))},
            join_of_pair(*s.sharp, pair) == Join::max};
}

/// A place on the leaf's edge within its core that it shows: nearest the centre, or to either side.
std::optional<Vec3d> place_to_start(const Surfel& s, std::size_t pair) {
    const SheetPair& sheets = kSheetPairs[pair];
    const auto middle = nearest_on_edge(s, sheets, {});
    if (!middle) return std::nullopt;
    const Vec3d along =
        normalized(cross(s.sheet_gradient(sheets.a, *middle), s.sheet_gradient(sheets.b, *middle)));
    const bool corner = s.n_sheets() > 2;  // likely in the middle
    for (const double offset : {0.0, 0.2, -0.2, 0.4, -0.4, 0.6, -0.6}) {
        if (corner && offset == 0.0) continue;
        const auto x = nearest_on_edge(s, sheets, *middle + along * offset);
        if (x && sq_length(*x) < kHitTrim * kHitTrim && edge_shows(s, sheets, *x)) return x;
    }
    return std::nullopt;
}

EdgePoint edge_point(const BlendedEdge& at, double way) {
    const Vec3d along = normalized(cross(at.normal[0], at.normal[1])) * way;
    return {at.point, to_float(along), {to_float(at.normal[0]), to_float(at.normal[1])}};
}

bool returns_to(const EdgePoint& start, const EdgePoint& from, const EdgePoint& to) {
    const Vec3d d = to.point - from.point, to_start = start.point - from.point;
    const double sq = sq_length(d), share = std::clamp(dot(to_start, d) / sq, 0.0, 1.0);
    return sq_length(to_start - d * share) < 0.0625 * sq &&
           dot(start.tangent, from.tangent) > 0.5f;
}

/// No edge turns so fast, nor does it come back: another one, or a fold of a leaf's own.
bool leads_on(const EdgePoint& from, const EdgePoint& to, double step) {
    const Vec3d moved = to.point - from.point;
    return !(dot(to.tangent, from.tangent) < 0.5f) &&
           dot(moved, to_double(from.tangent)) > 0.3 * step &&
           !(sq_length(moved) > 4 * step * step);
}

void append_numbers(const std::vector<LeafEdge>& parts, std::vector<std::uint32_t>& out) {
    for (const LeafEdge& part : parts) out.push_back(static_cast<std::uint32_t>(part.number()));
}

}  // namespace

EdgePoint EdgeStart::point(double way) const { return edge_point(at, way); }

std::optional<EdgeStart> EdgeWalker::start(std::size_t leaf, std::size_t pair) {
    const Surfel& s = leaves_.leaf(leaf);
    const auto x = place_to_start(s, pair);
    if (!x) return std::nullopt;
    EdgeSide side = side_of(s, pair, *x);
    const auto at = blender_.settle(s.center + *x * s.support_radius, side);
    if (!at || !at->in_core || at->cut > at->shown) return std::nullopt;
    side.normal = at->normal;
    EdgeStart start{*at, side, {}};
    append_numbers(blender_.parts(), start.parts);
    return start;
}

EdgeWalk EdgeWalker::follow(const EdgeStart& start, double way, const PassedEdges& passed) {
    EdgeWalk walk;
    EdgeSide side = start.side;
    const EdgePoint first = start.point(way);
    EdgePoint at = first;
    double step = kEdgeStep * start.at.radius;
    while (walk.steps.size() < kMostPoints) {
        const auto next = blender_.settle(at.point + to_double(at.tangent) * step, side);
        if (!next) break;
        const EdgePoint there = edge_point(*next, way);
        if (!leads_on(at, there, step)) break;
        if (next->cut > next->shown) {
            walk.corner = corner_here(next->point);
            break;
        }
        if (walk.steps.size() > 3 && returns_to(first, at, there)) {
            walk.closed = true;
            break;
        }
        if (all_passed(passed)) break;
        append_numbers(blender_.parts(), walk.parts);
        walk.steps.push_back({there, next->radius, next->in_core, walk.parts.size()});
        at = there, side.normal = next->normal, step = kEdgeStep * next->radius;
    }
    return walk;
}

/// The corner that ends an edge: the nearest of the leaves that have the edge.
std::uint32_t EdgeWalker::corner_here(const Vec3d& p) const {
    std::uint32_t best = kNoCorner;
    double least = INFINITY;
    for (const LeafEdge& part : blender_.parts()) {
        const std::uint32_t corner = corners_.nearest(part.leaf, part.pair, p);
        if (corner == kNoCorner) continue;
        const double sq = sq_length(corners_[corner].point - p);
        if (sq < least) least = sq, best = corner;
    }
    return best;
}

bool EdgeWalker::all_passed(const PassedEdges& passed) const {
    const auto& parts = blender_.parts();
    return std::all_of(parts.begin(), parts.end(),
                       [&](const LeafEdge& part) { return passed[part.number()] != 0; });
}

}  // namespace slim
