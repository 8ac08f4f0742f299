#include "slim/edges/join_edges.h"

#include "slim/base/bbox.h"
#include "slim/neighbors/box_tree.h"
#include "slim/neighbors/morton.h"

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <utility>

namespace slim {
namespace {

/// A free end of an edge: its number, and 0 for the first point, 1 for the last.
struct FreeEnd {
    std::uint32_t edge;
    std::uint8_t side;
    Vec3d point, outwards;
    double radius;
};

std::vector<FreeEnd> free_ends(const std::vector<TracedEdge>& edges) {
    std::vector<FreeEnd> ends;
    for (std::uint32_t i = 0; i < edges.size(); ++i)
        for (const std::uint8_t side : {std::uint8_t{0}, std::uint8_t{1}}) {
            const SharpEdge& e = edges[i].edge;
            if (e.closed || e.corner[side] != kNoCorner) continue;
            const EdgePoint& p = side ? e.points.back() : e.points.front();
            ends.push_back({i, side, p.point, to_double(p.tangent) * (side ? 1.0 : -1.0),
                            edges[i].radius[side]});
        }
    std::sort(ends.begin(), ends.end(), [](const FreeEnd& a, const FreeEnd& b) {
        return std::tie(a.point.x, a.edge, a.side) < std::tie(b.point.x, b.edge, b.side);
    });
    return ends;
}

bool same_faces(const SharpEdge& a, std::uint8_t side_a, const SharpEdge& b, std::uint8_t side_b) {
    constexpr float kLeast = 0.8f;
    const auto& n = (side_a ? a.points.back() : a.points.front()).normal;
    const auto& m = (side_b ? b.points.back() : b.points.front()).normal;
    // Edges run with their first face to one side: one that is turned about has them swapped.
    const std::size_t k = side_a == side_b ? 1 : 0;
    return a.convex == b.convex && dot(n[0], m[k]) > kLeast && dot(n[1], m[1 - k]) > kLeast;
}

/// The gap between two ends; negative if they do not lead to each other.
double gap(const std::vector<TracedEdge>& edges, const FreeEnd& a, const FreeEnd& b) {
    constexpr double kLeads = 0.7;
    const Vec3d d = b.point - a.point;
    const double apart = length(d);
    if (!(apart < std::min(a.radius, b.radius)) ||
        (a.edge == b.edge && edges[a.edge].edge.points.size() < 8))
        return -1;
    if (!(dot(d, a.outwards) >= kLeads * apart) || !(-dot(d, b.outwards) >= kLeads * apart))
        return -1;
    return same_faces(edges[a.edge].edge, a.side, edges[b.edge].edge, b.side) ? apart : -1;
}

struct Bridge {
    double gap;
    std::uint32_t a, b;  // ends
};

/// The numbers of ends along a Morton curve, for BoxTree.
std::vector<std::uint32_t> along_curve(const std::vector<FreeEnd>& ends) {
    Bbox box;
    for (const FreeEnd& end : ends) box.extend(end.point);
    const MortonCurve curve(box);
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(ends.size());
    for (std::uint32_t i = 0; i < ends.size(); ++i) keys[i] = {curve.key(ends[i].point), i};
    std::sort(keys.begin(), keys.end());
    std::vector<std::uint32_t> order(ends.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = keys[i].second;
    return order;
}

/// Pairs that may be joined, nearest first.
std::vector<Bridge> bridges(const std::vector<TracedEdge>& edges,
                            const std::vector<FreeEnd>& ends) {
    const std::vector<std::uint32_t> order = along_curve(ends);
    const BoxTree boxes(order.size(), [&](std::size_t i) { return ends[order[i]].point; });
    std::vector<Bridge> out;
    for (std::uint32_t i = 0; i < ends.size(); ++i)
        boxes.for_buckets_in_ball(
            ends[i].point, ends[i].radius, [&](std::size_t begin, std::size_t end) {
                for (std::size_t k = begin; k < end; ++k)
                    if (order[k] > i)
                        if (const double d = gap(edges, ends[i], ends[order[k]]); d >= 0)
                            out.push_back({d, i, order[k]});
            });
    std::sort(out.begin(), out.end(), [](const Bridge& p, const Bridge& q) {
        return std::tie(p.gap, p.a, p.b) < std::tie(q.gap, q.a, q.b);
    });
    return out;
}

void turn_about(SharpEdge& e) {
    std::reverse(e.points.begin(), e.points.end());
    for (EdgePoint& p : e.points) p.tangent = -p.tangent, std::swap(p.normal[0], p.normal[1]);
    std::swap(e.corner[0], e.corner[1]);
}

constexpr std::uint32_t kNone = 0xffffffffu;
using Partners =
    std::vector<std::array<std::uint32_t, 2>>;  // by edge and side: the other end, 2 edge + side

/// Follows partners from an edge that is entered at `side`'s opposite; marks what it takes.
SharpEdge chain(std::vector<TracedEdge>& edges, const Partners& partners, std::uint32_t first,
                std::uint8_t leave, std::vector<std::uint8_t>& taken) {
    SharpEdge out = std::move(edges[first].edge);
    taken[first] = 1;
    if (leave == 0) turn_about(out);
    for (std::uint32_t next = partners[first][leave]; next != kNone;) {
        const std::uint32_t i = next / 2;
        const auto enter = static_cast<std::uint8_t>(next % 2);
        if (taken[i]) {
            out.closed = i == first;
            break;
        }
        taken[i] = 1;
        SharpEdge more = std::move(edges[i].edge);
        if (enter == 1) turn_about(more);
        out.points.insert(out.points.end(), more.points.begin(), more.points.end());
        out.n_leaves += more.n_leaves, out.corner[1] = more.corner[1];
        next = partners[i][1 - enter];
    }
    return out;
}

}  // namespace

std::vector<SharpEdge> joined_edges(std::vector<TracedEdge> edges) {
    const std::vector<FreeEnd> ends = free_ends(edges);
    Partners partners(edges.size(), {kNone, kNone});
    for (const Bridge& bridge : bridges(edges, ends)) {
        const FreeEnd &a = ends[bridge.a], &b = ends[bridge.b];
        std::uint32_t &to_b = partners[a.edge][a.side], &to_a = partners[b.edge][b.side];
        if (to_b != kNone || to_a != kNone) continue;
        to_b = 2 * b.edge + b.side, to_a = 2 * a.edge + a.side;
    }
    std::vector<SharpEdge> out;
    std::vector<std::uint8_t> taken(edges.size(), 0);
    for (const bool open : {true, false})  // chains from their ends, then rings
        for (std::uint32_t i = 0; i < edges.size(); ++i) {
            if (taken[i]) continue;
            const bool first = partners[i][0] == kNone, last = partners[i][1] == kNone;
            if (open && !first && !last) continue;
            out.push_back(chain(edges, partners, i, first || !last ? 1 : 0, taken));
        }
    return out;
}

}  // namespace slim
