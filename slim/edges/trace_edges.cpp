#include "slim/edges/trace_edges.h"

#include "slim/base/parallel.h"
#include "slim/edges/corners.h"
#include "slim/edges/edge_blend.h"
#include "slim/edges/edge_walk.h"
#include "slim/edges/join_edges.h"
#include "slim/edges/likely_starts.h"
#include "slim/edges/weak_edges.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace slim {
namespace {

constexpr std::uint32_t kNobody = 0xffffffffu;
constexpr std::size_t kAtOnce = 32;  // edges that are followed at the same time

/// An edge from its start both ways, as followed without knowledge of those beside it.
struct WalkedEdge {
    EdgeStart start;
    EdgeWalk ahead;
    std::optional<EdgeWalk> back;  ///< if it does not come back to its start
};

std::optional<WalkedEdge> walk_edge(EdgeWalker& walker, std::uint32_t number,
                                    const PassedEdges& passed) {
    auto start = walker.start(number / kSheetPairs.size(), number % kSheetPairs.size());
    if (!start) return std::nullopt;
    WalkedEdge edge{std::move(*start), {}, {}};
    edge.ahead = walker.follow(edge.start, 1, passed);
    if (!edge.ahead.closed) edge.back = walker.follow(edge.start, -1, passed);
    return edge;
}

/// Edges in the order of the leaves: each takes what it passes, and ends where all has been taken.
/// They are walked several at once, from where they will likely start; what others took before them
/// is cut off when their turn comes, so that all is as if one had been followed after the other.
class EdgeTracer {
public:
    EdgeTracer(const BallIndex& leaves, const EachBatch& each_batch)
        : leaves_(leaves),
          each_batch_(each_batch),
          corners_(leaves),
          walker_(leaves, corners_),
          passed_(kSheetPairs.size() * leaves.n_leaves(), 0),
          owner_(kSheetPairs.size() * leaves.n_leaves(), kNobody) {}

    std::vector<TracedEdge> run() {
        const std::size_t n = leaves_.n_leaves();
        likely_ = likely_starts(leaves_, corners_,
                                [&](std::size_t done, std::size_t) { tell(done); });
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t pair = 0; pair < n_sheet_pairs(leaves_.leaf(i)); ++pair)
                if (const auto number = static_cast<std::uint32_t>(kSheetPairs.size() * i + pair);
                    !passed_[number]) {
                    auto edge = walked(number);
                    if (edge) take(std::move(*edge));
                    tell(n + i);
                }
        return std::move(edges_);
    }

private:
    struct Half {
        std::vector<EdgePoint> points;  ///< without the start
        std::uint32_t corner = kNoCorner;
        double radius = 0;
        bool closed = false;
    };

    void tell(std::size_t done) const {
        if (each_batch_) each_batch_(done, 2 * leaves_.n_leaves());
    }

    /// The edge from that start: one of those walked together, or walked now.
    std::optional<WalkedEdge> walked(std::uint32_t number) {
        while (!batch_.empty() && next_ < batch_.size() && batch_[next_] < number) ++next_;
        if (next_ == batch_.size()) walk_batch(number);
        if (next_ < batch_.size() && batch_[next_] == number)
            return std::move(edges_of_batch_[next_++]);
        return walk_edge(walker_, number, passed_);
    }

    /// Walks the next likely edges together, if this is the first of them.
    void walk_batch(std::uint32_t number) {
        while (next_likely_ < likely_.size() && likely_[next_likely_] < number) ++next_likely_;
        batch_.clear(), next_ = 0;
        if (next_likely_ == likely_.size() || likely_[next_likely_] != number) return;
        for (; next_likely_ < likely_.size() && batch_.size() < kAtOnce; ++next_likely_)
            if (!passed_[likely_[next_likely_]]) batch_.push_back(likely_[next_likely_]);
        edges_of_batch_.assign(batch_.size(), std::nullopt);
        parallel_blocks(batch_.size(), 1, [&](std::size_t i, std::size_t) {
            EdgeWalker walker(leaves_, corners_);
            edges_of_batch_[i] = walk_edge(walker, batch_[i], passed_);
        });
    }

    void take(WalkedEdge edge) {
        ++number_, n_leaves_ = 0;
        if (passed_by_others(edge.start.parts)) return;
        take_parts(edge.start.parts);
        const double radius = edge.start.at.radius;
        Half ahead = part_of(std::move(edge.ahead), edge.start.point(1), radius);
        Half back;
        if (!ahead.closed) {
            if (!edge.back) edge.back = walker_.follow(edge.start, -1, passed_);
            back = part_of(std::move(*edge.back), edge.start.point(-1), radius);
        }
        put_together(edge.start.point(1), std::move(back), std::move(ahead),
                     edge.start.side.convex);
    }

    /// Whether all leaves' edges here have been passed by edges before this one.
    bool passed_by_others(std::span<const std::uint32_t> parts) const {
        return std::none_of(parts.begin(), parts.end(), [&](std::uint32_t part) {
            return owner_[part] == kNobody || owner_[part] == number_;
        });
    }
    void take_parts(std::span<const std::uint32_t> parts) {
        for (const std::uint32_t part : parts)
            if (owner_[part] == kNobody) owner_[part] = number_, passed_[part] = 1, ++n_leaves_;
    }

    /// What of a walk no other edge passed before, which it takes.
    Half part_of(EdgeWalk walk, const EdgePoint& start, double radius) {
        Half half;
        half.radius = radius;
        std::size_t in_core = 0;  // points up to the last one that a core holds
        for (std::size_t i = 0; i < walk.steps.size() && !passed_by_others(walk.parts_of(i)); ++i) {
            take_parts(walk.parts_of(i));
            half.points.push_back(walk.steps[i].point);
            if (walk.steps[i].in_core) in_core = i + 1, half.radius = walk.steps[i].radius;
        }
        if (half.points.size() == walk.steps.size())
            half.corner = walk.corner, half.closed = walk.closed;
        if (half.corner != kNoCorner) end_at_corner(start, half);
        if (half.corner == kNoCorner && !half.closed) half.points.resize(in_core);
        return half;
    }

    /// Puts the corner in place of the points beside and beyond it; none if it lies off the edge.
    void end_at_corner(const EdgePoint& start, Half& half) const {
        const Corner& corner = corners_[half.corner];
        const auto last = [&]() -> const EdgePoint& {
            return half.points.empty() ? start : half.points.back();
        };
        const double near = 0.5 * kEdgeStep * corner.radius;
        const Vec3d along = to_double(last().tangent);
        const Vec3d ahead = corner.point - last().point;
        if (sq_length(ahead - along * dot(ahead, along)) > 16 * near * near ||
            dot(ahead, along) > 8 * near) {
            half.corner = kNoCorner;
            return;
        }
        while (!half.points.empty() &&
               dot(corner.point - last().point, to_double(last().tangent)) < near)
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
                   length(half.points[0].point - first.point) < 0.5 * kEdgeStep * half.radius;
        };
        if (!at_start(back) && !at_start(ahead)) edge.points.push_back(first);
        edge.points.insert(edge.points.end(), ahead.points.begin(), ahead.points.end());
        if (edge.points.size() > 1)
            edges_.push_back({std::move(edge), {back.radius, ahead.radius}});
    }

    const BallIndex& leaves_;
    const EachBatch& each_batch_;
    const Corners corners_;
    EdgeWalker walker_;
    std::vector<std::uint32_t> likely_,
        batch_;  ///< where edges likely start; those that were walked together
    std::size_t next_likely_ = 0, next_ = 0;
    std::vector<std::optional<WalkedEdge>> edges_of_batch_;
    PassedEdges passed_;
    std::vector<std::uint32_t>
        owner_;  ///< number of the edge that passed each edge of each leaf first
    std::uint32_t number_ = 0;
    std::size_t n_leaves_ = 0;
    std::vector<TracedEdge> edges_;
};

}  // namespace

std::vector<SharpEdge> trace_sharp_edges(const SurfelTree& tree, bool loose,
                                         const EachBatch& each_batch) {
    if (tree.sharp().empty()) return {};
    const BallIndex leaves = sharp_leaves(tree, loose);
    if (leaves.n_leaves() == 0) return {};
    return without_weak_edges(joined_edges(EdgeTracer(leaves, each_batch).run()),
                              sharp_roughness(tree, loose));
}

}  // namespace slim
