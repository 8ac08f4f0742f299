#pragma once

#include "slim/model/point_block.h"
#include "slim/normals/estimate.h"
#include "slim/normals/sign_merge.h"

#include <cstdint>
#include <vector>

namespace slim {

/// Points whose normals surely agree up to signs, and these signs.
struct SignGroups {
    static constexpr std::uint32_t kKnown = 0;  ///< the group of all points whose sign is known

    std::uint32_t n = 1;
    std::vector<std::uint32_t> of;       ///< of each point
    std::vector<std::uint8_t> opposed;   ///< whether a point's normal opposes its group's
};

/// Groups of neighbours near each other on the curve whose normals lie nearly along one line; those
/// with known signs are all in one. known: by point; every point of unknown sign is in the graph.
/// Parallel; 5 bytes a point. In thick noise less alike neighbours are joined, so that groups stay
/// far fewer than points.
SignGroups group_by_sign(const PointBlock& points, const NeighborGraph& graph,
                         const std::vector<bool>& known);

/// What neighbours in different groups say of the groups' signs: the sum of their votes' squares,
/// with the votes' signs. One vote for two groups, in order. Parallel.
std::vector<SignVote> votes_between(const PointBlock& points, const NeighborGraph& graph,
                                    const SignGroups& groups);

}  // namespace slim
