#pragma once

#include "slim/model/point_block.h"
#include "slim/neighbors/nearest.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// k of the nearest neighbours of some points of a block, themselves among them.
struct NeighborGraph {
    std::size_t k = 0;
    std::vector<std::uint32_t> points;     ///< rising
    std::vector<std::uint32_t> neighbors;  ///< k a point
    /// points that have no patch of neighbours, but a line of them: their normals say nothing
    std::size_t n_on_lines = 0;
    /// points whose normals are estimated from more than k, as noise is as thick as those reach
    std::size_t n_widened = 0;

    std::span<const std::uint32_t> of(std::size_t row) const {
        return {neighbors.data() + row * k, k};
    }
};

/// Whether noise may be so thick that the usual neighbours of a point show no plane.
enum class NoiseOfPoints : std::uint8_t { thin, thick };

/// Unit normals of the points in `wanted` (rising) by principal components: the direction of least
/// spread of a point's k nearest neighbours at distinct places. Sign arbitrary. Neighbours that
/// span no plane (all equal, or on a line) give any direction normal to what they span; such points
/// are counted in `degenerate` (of those with counted[i]; empty: all). The block must be in Morton
/// order (sort_along_curve): a repeat takes the normal of the point before it, which is its only
/// neighbour in the graph returned. search: over the block's positions
/// Where neighbours lie on a scan line whose next ones are far, twice as many are taken until they
/// are a patch, up to 512 (notes/0005); not where such points are one in a hundred or fewer; where
/// they are less than half, not far (wires over a ground, notes/0007).
/// In thick noise, too, twice as many are taken, up to 512, until their plane is known to 0.2
/// radians (notes/0008).
/// The graph lists 16 of the k at most. Cost: 0.8 us a point and core at k = 16, of a point on a
/// line up to 15, in thick noise as much again for each time that more neighbours are taken; 78
/// bytes a point.
NeighborGraph estimate_normals(PointBlock& points, const NearestSearch& search,
                               std::span<const std::uint32_t> wanted, std::size_t k,
                               std::size_t& degenerate, const std::vector<bool>& counted = {},
                               NoiseOfPoints noise = NoiseOfPoints::thin);

/// k, or twice as many and so on where the neighbours of most samples lie in a plane that is not
/// that of many more: scan lines far from each other whose noise is thick within their own plane.
/// samples: by falling priority; 300 that are no repeats serve, k is kept of fewer than 50. Cost:
/// 10 us a sample.
std::size_t neighbors_beyond_strips(const NearestSearch& search,
                                    std::span<const std::uint32_t> samples, std::size_t k);

}  // namespace slim
