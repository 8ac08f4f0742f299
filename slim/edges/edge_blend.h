#pragma once

#include "slim/edges/edge_leaf.h"
#include "slim/model/sharp_edge.h"
#include "slim/model/surfel_tree.h"
#include "slim/tree/ball_index.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace slim {

/// The sharp leaves of a model that are drawn. 280 bytes each.
BallIndex sharp_leaves(const SurfelTree& tree, bool loose);

/// Which edge is followed: the outward normals of its two faces, and how they are joined.
struct EdgeSide {
    std::array<Vec3d, 2> normal;
    bool convex = true;
};

/// One edge of one leaf.
struct LeafEdge {
    std::uint32_t leaf = 0;
    std::uint8_t pair = 0;
    std::size_t number() const { return kSheetPairs.size() * std::size_t{leaf} + pair; }
};

/// The leaves' edges about a place, averaged.
struct BlendedEdge {
    Vec3d point;                  ///< frame of the job
    std::array<Vec3d, 2> normal;  ///< unit, outwards, in the order of the side asked for
    double radius = 0;            ///< mean rho
    double shown = 0,
           cut = 0;  ///< weight of the leaves that show the edge there, and of those whose third
                     ///< sheet cuts it
    bool in_core = false;  ///< some leaf shows it within its core, where first hits are looked for
};

/// Blends edges of leaves as eq. (6) (Ohtake 2005) blends surfaces: every leaf that holds p and has
/// an edge of that side there, no farther than kBelongs rho, moves p to its own edge; the mean of
/// these points by the weights G(|p - c| / rho). The leaves that took part, as `parts`. Nothing
/// where there is none.
class EdgeBlender {
public:
    explicit EdgeBlender(const BallIndex& leaves) : leaves_(leaves) {}
    /// Two passes, from p and from where the first led.
    std::optional<BlendedEdge> settle(const Vec3d& p, const EdgeSide& side);
    const std::vector<LeafEdge>& parts() const { return parts_; }

private:
    std::optional<BlendedEdge> blend(const Vec3d& p, const EdgeSide& side);

    const BallIndex& leaves_;
    std::vector<const Surfel*> supporters_;
    std::vector<LeafEdge> parts_;
};

}  // namespace slim
