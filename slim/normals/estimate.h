#pragma once

#include "slim/model/point_block.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// k nearest neighbours of every point of a block, itself included; k indices a point.
struct NeighborGraph {
    std::size_t k = 0;
    std::vector<std::uint32_t> neighbors;

    std::span<const std::uint32_t> of(std::size_t i) const {
        return {neighbors.data() + i * k, k};
    }
};

/// Exact graph (FLANN). Cost: about 1.5 us a point and core; 4 k bytes a point.
NeighborGraph neighbor_graph(const PointBlock& points, std::size_t k);

/// Unit normals of the points in `wanted` by principal components: the direction of least spread of a
/// point's neighbours. Sign arbitrary. Neighbours that span no plane (all equal, or on a line) give any
/// direction normal to what they span; such points are counted in `degenerate`.
void estimate_normals(PointBlock& points, const NeighborGraph& graph,
                      std::span<const std::uint32_t> wanted, std::size_t& degenerate);

}  // namespace slim
