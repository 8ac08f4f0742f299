#pragma once

#include "slim/edges/corners.h"
#include "slim/edges/edge_blend.h"
#include "slim/model/sharp_edge.h"
#include "slim/tree/ball_index.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace slim {

inline constexpr double kEdgeStep = 0.1;  ///< along an edge, of the leaves' mean radius

/// Which edges of leaves (LeafEdge::number()) have been passed: 0 or 1 for each.
using PassedEdges = std::vector<std::uint8_t>;

/// One way along an edge, as far as it goes.
struct EdgeWalk {
    struct Step {
        EdgePoint point;
        double radius;          ///< mean of the leaves here
        bool in_core;           ///< some leaf shows it within its core
        std::size_t parts_end;  ///< of its leaves' edges in `parts`
    };
    std::vector<Step> steps;           ///< without the start
    std::vector<std::uint32_t> parts;  ///< LeafEdge::number() of those that took part, step by step
    std::uint32_t corner = kNoCorner;  ///< that cuts the edge off beyond the last step
    bool closed = false;               ///< it comes back to its start after the last step

    std::span<const std::uint32_t> parts_of(std::size_t step) const {
        const std::size_t begin = step > 0 ? steps[step - 1].parts_end : 0;
        return std::span(parts).subspan(begin, steps[step].parts_end - begin);
    }
};

/// Where a leaf's edge is followed from.
struct EdgeStart {
    BlendedEdge at;
    EdgeSide side;
    std::vector<std::uint32_t> parts;  ///< LeafEdge::number() of those that took part
    /// way 1: as the side has it, -1: the other way
    EdgePoint point(double way) const;
};

/// Follows edges over leaves (notes/0001) without a thought of others, but that it stops where all
/// leaves' edges have been passed. One thread's; what it refers to must outlive it.
class EdgeWalker {
public:
    EdgeWalker(const BallIndex& leaves, const Corners& corners)
        : leaves_(leaves), blender_(leaves), corners_(corners) {}

    /// On the blended edge, from a place within the leaf's core that it shows: nearest the centre,
    /// or to either side. Nothing where there is none.
    std::optional<EdgeStart> start(std::size_t leaf, std::size_t pair);
    EdgeWalk follow(const EdgeStart& start, double way, const PassedEdges& passed);

private:
    std::uint32_t corner_here(const Vec3d& p) const;
    bool all_passed(const PassedEdges& passed) const;

    const BallIndex& leaves_;
    EdgeBlender blender_;
    const Corners& corners_;
};

}  // namespace slim
