#include "slim/edges/trace_edges.h"

#include "slim/edges/edge_blend.h"
#include "slim/edges/join_edges.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace slim {
namespace {

constexpr double kStep = 0.1;  // of the leaves' mean radius
constexpr std::size_t kMostPoints = 100'000;
constexpr std::uint32_t kNobody = 0xffffffffu;

EdgeSide side_of(const Surfel& s, std::size_t pair, const Vec3d& x) {
    const SheetPair& sheets = kSheetPairs[pair];
    return {{normalized(s.sheet_gradient(sheets.a, x)), normalized(s.sheet_gradient(sheets.b, x))},
            join_of_pair(*s.sharp, pair) == Join::max};
}

/// A place where three faces meet, of all leaves that show it.
struct Corner {
    Vec3d point;
    double radius;
};

/// Corners as they are found.
class Corners {
public:
    explicit Corners(const BallIndex& leaves) : leaves_(leaves) {
        for (std::size_t i = 0; i < leaves.n_leaves(); ++i) {
            const Surfel& s = leaves.leaf(i);
            const auto x = s.n_sheets() == 3 ? corner_of(s) : std::nullopt;
            of_leaf_.push_back(x && sq_length(*x) < 1 ? find_or_add(s, *x) : kNoCorner);
        }
    }
    std::uint32_t of_leaf(std::size_t leaf) const { return of_leaf_[leaf]; }
    const Corner& operator[](std::uint32_t number) const { return found_[number]; }

private:
    /// The first leaf's corner stands for those of later ones within a share of their radius.
    std::uint32_t find_or_add(const Surfel& s, const Vec3d& x) {
        constexpr double kSame = 0.15;
        const Vec3d p = s.center + x * s.support_radius;
        leaves_.supporters(p, near_);
        for (const Surfel* other : near_) {
            const std::size_t leaf = leaves_.number_of(other);
            if (leaf >= of_leaf_.size() || of_leaf_[leaf] == kNoCorner) continue;
            const Corner& corner = found_[of_leaf_[leaf]];
            const double reach = kSame * std::min(corner.radius, s.support_radius);
            if (sq_length(corner.point - p) < reach * reach) return of_leaf_[leaf];
        }
        found_.push_back({p, s.support_radius});
        return static_cast<std::uint32_t>(found_.size() - 1);
    }

    const BallIndex& leaves_;
    std::vector<const Surfel*> near_;
    std::vector<Corner> found_;
    std::vector<std::uint32_t> of_leaf_;
};

class EdgeTracer {
public:
    explicit EdgeTracer(const BallIndex& leaves)
        : leaves_(leaves), blender_(leaves), corners_(leaves), owner_(3 * leaves.n_leaves(), kNobody) {}

    std::vector<TracedEdge> run() {
        for (std::size_t i = 0; i < leaves_.n_leaves(); ++i)
            for (std::size_t pair = 0; pair < n_sheet_pairs(leaves_.leaf(i)); ++pair)
                if (owner_[3 * i + pair] == kNobody) start(i, pair);
        return std::move(edges_);
    }

private:
    struct Half {
        std::vector<EdgePoint> points;  ///< without the start
        std::uint32_t corner = kNoCorner;
        double radius = 0;
        bool closed = false;
    };

    /// A place on the leaf's edge within its core that it shows: nearest the centre, or to either side.
    std::optional<Vec3d> place_to_start(const Surfel& s, std::size_t pair) const {
        const SheetPair& sheets = kSheetPairs[pair];
        const auto middle = nearest_on_edge(s, sheets, {});
        if (!middle) return std::nullopt;
        const Vec3d along =
            normalized(cross(s.sheet_gradient(sheets.a, *middle), s.sheet_gradient(sheets.b, *middle)));
        const bool corner = s.n_sheets() == 3;  // likely in the middle
        for (const double offset : {0.0, 0.2, -0.2, 0.4, -0.4, 0.6, -0.6}) {
            if (corner && offset == 0.0) continue;
            const auto x = nearest_on_edge(s, sheets, *middle + along * offset);
            if (x && sq_length(*x) < kHitTrim * kHitTrim && edge_shows(s, sheets, *x)) return x;
        }
        return std::nullopt;
    }

    void start(std::size_t leaf, std::size_t pair) {
        const Surfel& s = leaves_.leaf(leaf);
        const auto x = place_to_start(s, pair);
        if (!x) return;
        EdgeSide side = side_of(s, pair, *x);
        const auto at = blender_.settle(s.center + *x * s.support_radius, side);
        if (!at || !at->in_core || at->cut > at->shown) return;
        ++number_, n_leaves_ = 0;
        side.normal = at->normal;
        if (passed_by_others()) return;
        take_parts();
        const EdgePoint first = edge_point(*at, 1);
        Half ahead = follow(*at, side, 1);
        Half back;
        if (!ahead.closed) back = follow(*at, side, -1);
        put_together(first, std::move(back), std::move(ahead), side.convex);
    }

    static EdgePoint edge_point(const BlendedEdge& at, double way) {
        const Vec3d along = normalized(cross(at.normal[0], at.normal[1])) * way;
        return {at.point, to_float(along), {to_float(at.normal[0]), to_float(at.normal[1])}};
    }

    /// Whether all leaves here have been passed by edges before this one.
    bool passed_by_others() const {
        return std::none_of(blender_.parts().begin(), blender_.parts().end(), [&](const LeafEdge& part) {
            return owner_[part.number()] == kNobody || owner_[part.number()] == number_;
        });
    }
    void take_parts() {
        for (const LeafEdge& part : blender_.parts())
            if (owner_[part.number()] == kNobody) owner_[part.number()] = number_, ++n_leaves_;
    }

    /// The corner that ends an edge: of the nearest leaf that cuts it.
    std::uint32_t corner_here(const Vec3d& p) const {
        std::uint32_t best = kNoCorner;
        double least = INFINITY;
        for (const LeafEdge& part : blender_.parts()) {
            const std::uint32_t corner = corners_.of_leaf(part.leaf);
            if (corner == kNoCorner) continue;
            const double sq = sq_length(corners_[corner].point - p);
            if (sq < least) least = sq, best = corner;
        }
        return best;
    }

    static bool returns_to(const EdgePoint& start, const EdgePoint& from, const EdgePoint& to) {
        const Vec3d d = to.point - from.point, to_start = start.point - from.point;
        const double sq = sq_length(d), share = std::clamp(dot(to_start, d) / sq, 0.0, 1.0);
        return sq_length(to_start - d * share) < 0.0625 * sq && dot(start.tangent, from.tangent) > 0.5f;
    }

    Half follow(const BlendedEdge& from, EdgeSide side, double way) {
        Half half;
        EdgePoint at = edge_point(from, way);
        const EdgePoint start = at;
        double step = kStep * from.radius;
        half.radius = from.radius;
        std::size_t in_core = 0;  // points up to the last one that a core holds
        while (half.points.size() < kMostPoints) {
            const auto next = blender_.settle(at.point + to_double(at.tangent) * step, side);
            if (!next) break;
            const EdgePoint there = edge_point(*next, way);
            // No edge turns so fast, nor does it come back: another one, or a fold of a leaf's own.
            const Vec3d moved = next->point - at.point;
            if (dot(there.tangent, at.tangent) < 0.5f || !(dot(moved, to_double(at.tangent)) > 0.3 * step) ||
                sq_length(moved) > 4 * step * step)
                break;
            if (next->cut > next->shown) {
                half.corner = corner_here(next->point);
                break;
            }
            if (half.points.size() > 3 && returns_to(start, at, there)) {
                half.closed = true;
                break;
            }
            if (passed_by_others()) break;
            take_parts();
            half.points.push_back(there);
            if (next->in_core) in_core = half.points.size();
            at = there, side.normal = next->normal, step = kStep * next->radius;
            if (next->in_core) half.radius = next->radius;
        }
        if (half.corner != kNoCorner) end_at_corner(start, half);
        if (half.corner == kNoCorner && !half.closed) half.points.resize(in_core);
        return half;
    }

    /// Puts the corner in place of the points beside and beyond it; none if it lies off the edge.
    void end_at_corner(const EdgePoint& start, Half& half) {
        const Corner& corner = corners_[half.corner];
        const auto last = [&]() -> const EdgePoint& {
            return half.points.empty() ? start : half.points.back();
        };
        const double near = 0.5 * kStep * corner.radius;
        const Vec3d along = to_double(last().tangent);
        const Vec3d ahead = corner.point - last().point;
        if (sq_length(ahead - along * dot(ahead, along)) > 16 * near * near || dot(ahead, along) > 8 * near) {
            half.corner = kNoCorner;
            return;
        }
        while (!half.points.empty() && dot(corner.point - last().point, to_double(last().tangent)) < near)
            half.points.pop_back();
        EdgePoint end = last();
        const Vec3d chord = corner.point - end.point;
        end.point = corner.point;
        // The chord's mirror image of the tangent before it: the circle through both.
        const Vec3d unit = normalized(chord), t = to_double(end.tangent);
        if (sq_length(unit) > 0) end.tangent = to_float(normalized(unit * (2 * dot(unit, t)) - t));
        half.points.push_back(end);
    }

    void put_together(const EdgePoint& first, Half back, Half ahead, bool convex) {
        SharpEdge edge;
        edge.convex = convex, edge.closed = ahead.closed, edge.n_leaves = n_leaves_;
        edge.corner = {back.corner, ahead.corner};
        edge.points.reserve(back.points.size() + 1 + ahead.points.size());
        for (auto p = back.points.rbegin(); p != back.points.rend(); ++p) {
            p->tangent = -p->tangent;
            edge.points.push_back(*p);
        }
        // A start at a corner's side would be there twice.
        const auto at_start = [&](const Half& half) {
            return half.corner != kNoCorner && half.points.size() == 1 &&
                   length(half.points[0].point - first.point) < 0.5 * kStep * half.radius;
        };
        if (!at_start(back) && !at_start(ahead)) edge.points.push_back(first);
        edge.points.insert(edge.points.end(), ahead.points.begin(), ahead.points.end());
        if (edge.points.size() > 1) edges_.push_back({std::move(edge), {back.radius, ahead.radius}});
    }

    const BallIndex& leaves_;
    EdgeBlender blender_;
    Corners corners_;
    std::vector<std::uint32_t> owner_;  ///< number of the edge that passed each edge of each leaf first
    std::uint32_t number_ = 0;
    std::size_t n_leaves_ = 0;
    std::vector<TracedEdge> edges_;
};

}  // namespace

std::vector<SharpEdge> trace_sharp_edges(const SurfelTree& tree, bool loose) {
    if (tree.sharp().empty()) return {};
    const BallIndex leaves = sharp_leaves(tree, loose);
    if (leaves.n_leaves() == 0) return {};
    return joined_edges(EdgeTracer(leaves).run());
}

}  // namespace slim
