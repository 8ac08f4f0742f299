#pragma once

#include "slim/model/point_block.h"
#include "slim/neighbors/nearest.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// The k nearest neighbours of some points of a block, themselves included.
struct NeighborGraph {
    std::size_t k = 0;
    std::vector<std::uint32_t> points;     ///< rising
    std::vector<std::uint32_t> neighbors;  ///< k a point

    std::span<const std::uint32_t> of(std::size_t row) const {
        return {neighbors.data() + row * k, k};
    }
    /// Whether j is listed as a neighbour of i; false if only some points are in the graph.
    bool is_neighbor_too(std::uint32_t i, std::uint32_t j) const {
        if (i >= points.size() || points[i] != i) return false;
        const auto row = of(i);
        return std::find(row.begin(), row.end(), j) != row.end();
    }
};

/// Unit normals of the points in `wanted` (rising) by principal components: the direction of least
/// spread of a point's k nearest neighbours at distinct places. Sign arbitrary. Neighbours that
/// span no plane (all equal, or on a line) give any direction normal to what they span; such points
/// are counted in `degenerate` (of those with counted[i]; empty: all). The block must be in Morton
/// order (sort_along_curve): a repeat takes the normal of the point before it, which is its only
/// neighbour in the graph returned. search: over the block's positions
/// Cost: 0.8 us a point and core; 4 k + 12 bytes a point.
NeighborGraph estimate_normals(PointBlock& points, const NearestSearch& search,
                               std::span<const std::uint32_t> wanted, std::size_t k,
                               std::size_t& degenerate, const std::vector<bool>& counted = {});

}  // namespace slim
