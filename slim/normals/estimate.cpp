#include "slim/normals/estimate.h"

#include "slim/base/parallel.h"
#include "slim/normals/covariance.h"

#include <algorithm>
#include <atomic>

namespace slim {
namespace {

// middle / largest eigenvalue below which the points lie on a line
constexpr double kSpansPlane = 1e-10;

// neighbours of a point that the graph lists of more, evenly: what signs are voted by
constexpr std::size_t kListed = 16;

/// Repeats take the normal of the point before, which is their only neighbour.
void copy_to_repeats(const NearestSearch& search, NeighborGraph& graph, PointBlock& points) {
    for (std::size_t row = 0; row < graph.points.size(); ++row) {
        const std::uint32_t i = graph.points[row];
        if (!search.is_repeat(i)) continue;
        points.normal[i] = points.normal[i - 1];
        std::fill_n(graph.neighbors.begin() + static_cast<std::ptrdiff_t>(row * graph.k), graph.k,
                    i - 1);
    }
}

}  // namespace

NeighborGraph estimate_normals(PointBlock& points, const NearestSearch& search,
                               std::span<const std::uint32_t> wanted, std::size_t k,
                               std::size_t& degenerate, const std::vector<bool>& counted) {
    NeighborGraph graph;
    graph.k = std::min({k, kListed, points.size()});
    graph.points.assign(wanted.begin(), wanted.end());
    graph.neighbors.resize(wanted.size() * graph.k);
    std::vector<std::uint32_t> rows, searched;
    for (std::uint32_t row = 0; row < wanted.size(); ++row) {
        if (search.is_repeat(wanted[row])) continue;
        rows.push_back(row);
        searched.push_back(wanted[row]);
    }
    std::atomic<std::size_t> lines{0};
    search.for_each(searched, k, [&](std::size_t r, std::span<const std::uint32_t> neighbors) {
        const Spread spread = spread_of(points.position, neighbors);
        const bool counts = counted.empty() || counted[searched[r]];
        if (counts && !(spread.middle > kSpansPlane * spread.largest)) ++lines;
        points.normal[searched[r]] = normalized(to_float(spread.normal));
        const auto row = graph.neighbors.begin() + static_cast<std::ptrdiff_t>(rows[r] * graph.k);
        // Fewer distinct places than k: the rest of the row is the point itself.
        const std::size_t n = std::min(graph.k, neighbors.size());
        for (std::size_t i = 0; i < graph.k; ++i)
            row[static_cast<std::ptrdiff_t>(i)] =
                i < n ? neighbors[i * neighbors.size() / n] : searched[r];
    });
    degenerate = lines;
    copy_to_repeats(search, graph, points);
    return graph;
}

}  // namespace slim
