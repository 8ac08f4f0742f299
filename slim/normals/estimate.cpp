#include "slim/normals/estimate.h"

#include "slim/base/parallel.h"
#include "slim/normals/covariance.h"
#include "slim/normals/scan_line.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

namespace slim {
namespace {

// middle / largest eigenvalue below which the points lie on a line
constexpr double kSpansPlane = 1e-10;

constexpr std::size_t kFewLines = 100;  // less than one in so many points is let be
// middle / largest eigenvalue from which on more neighbours of a point on a line are a patch
constexpr double kPatch = 1.0 / 4;
constexpr std::size_t kMostOfPatch = 512;
// Where most of the cloud is dense both ways, lines are wires: what lies farther from one than so
// many reaches of its neighbours is no next line of a scan (notes/0007). 16 on a line reach 8
// spacings to both sides; lines q spacings apart are a patch from 1.1 q on, and as numbers double
// some are found up to q = 20.
constexpr double kFarthestOfFew = 3;

// The plane of a strip is not that of many more neighbours.
constexpr std::size_t kManyMore = 16, kStripSamples = 300, kFewestStripSamples = 50;

// Standard error of an estimate's direction, radians, from which on it says little of the surface.
constexpr double kDoubtful = 0.2;

// neighbours of a point that the graph lists of more, evenly: what signs are voted by
constexpr std::size_t kListed = 16;

/// What the neighbours of a point are.
enum class Kind : std::uint8_t { unknown, patch, line };

Kind kind_of(const Spread& spread) { return is_on_line(spread) ? Kind::line : Kind::patch; }

/// Whether noise is as thick as k neighbours reach. With r, the ratio of the two least eigenvalues,
/// the direction of the least has the standard error sqrt(r / k) / (1 - r) (first order
/// perturbation of the covariance of k normal variates). Where two faces meet at right angles r is
/// a quarter: 0.17 of 16.
bool is_doubtful(const Spread& s, std::size_t k) {
    const double ratio = s.middle > 0 ? s.smallest / s.middle : 1;
    return !(std::sqrt(ratio / static_cast<double>(k)) < kDoubtful * (1 - ratio));
}

/// Lists some of a point's neighbours, evenly; of fewer the rest of the row is the point itself.
void list_neighbors(NeighborGraph& graph, std::size_t row, std::span<const std::uint32_t> found) {
    const std::size_t n = std::min(graph.k, found.size());
    for (std::size_t i = 0; i < graph.k; ++i)
        graph.neighbors[row * graph.k + i] =
            i < n ? found[i * found.size() / n] : graph.points[row];
}

/// The rows most of whose neighbours have theirs on a line: it is not a thin spot, nor a line whose
/// noise makes it a patch here and there. None if they are few, all if most are.
std::vector<std::uint32_t> rows_on_lines(const NeighborGraph& graph,
                                         std::span<const std::uint32_t> rows,
                                         const std::vector<Kind>& kinds) {
    std::vector<std::uint32_t> out;
    for (const std::uint32_t row : rows) {
        std::ptrdiff_t lines_less_patches = 0;
        for (const std::uint32_t i : graph.of(row))
            lines_less_patches += kinds[i] == Kind::line ? 1 : kinds[i] == Kind::patch ? -1 : 0;
        if (lines_less_patches > 0) out.push_back(row);
    }
    if (2 * out.size() > rows.size()) return {rows.begin(), rows.end()};
    if (kFewLines * out.size() < rows.size()) out.clear();
    return out;
}

/// What more neighbours of a point show.
enum class Shown : std::uint8_t { plane, nothing_yet, nothing };

struct WidenedRows {
    std::vector<std::uint32_t> found, left;  ///< those with a plane, and the others, as they were
};

/// Estimates the normals of some rows from more neighbours than k, twice as many until they show a
/// plane, or are too many. judge(row, neighbors, spread): says which, and gives a plane's spread
template <class Judge>
WidenedRows widen(PointBlock& points, const NearestSearch& search, NeighborGraph& graph,
                  std::vector<std::uint32_t> rows, std::size_t k, const Judge& judge) {
    const std::size_t most = std::min(kMostOfPatch, points.size());
    WidenedRows out;
    while (!rows.empty() && k < most) {
        k = std::min(2 * k, most);
        std::vector<std::uint32_t> wanted;
        for (const std::uint32_t row : rows) wanted.push_back(graph.points[row]);
        std::vector<Shown> shown(rows.size());  // a byte each: threads write side by side
        search.for_each(wanted, k, [&](std::size_t r, std::span<const std::uint32_t> neighbors) {
            Spread spread;
            shown[r] = judge(rows[r], neighbors, spread);
            if (shown[r] != Shown::plane) return;
            points.normal[wanted[r]] = normalized(to_float(spread.normal));
            list_neighbors(graph, rows[r], neighbors);
        });
        std::size_t n_left = 0;
        for (std::size_t r = 0; r < rows.size(); ++r)
            if (shown[r] == Shown::nothing_yet) rows[n_left++] = rows[r];
            else (shown[r] == Shown::plane ? out.found : out.left).push_back(rows[r]);
        rows.resize(n_left);
    }
    out.left.insert(out.left.end(), rows.begin(), rows.end());
    return out;
}

/// Of rows whose neighbours lie on a line, until they are a patch; returns those that never have
/// one. farthest: of a patch, in reaches of the neighbours that the graph lists; infinite: as far
/// as may be
std::vector<std::uint32_t> widen_lines(PointBlock& points, const NearestSearch& search,
                                       NeighborGraph& graph, std::vector<std::uint32_t> rows,
                                       std::size_t k, double farthest) {
    const auto judge = [&](std::uint32_t row, std::span<const std::uint32_t> neighbors,
                           Spread& spread) {
        const std::uint32_t i = graph.points[row];
        const double near = sq_reach_of(points.position, i, graph.of(row));
        if (sq_reach_of(points.position, i, neighbors) > farthest * farthest * near)
            return Shown::nothing;
        spread = spread_of(points.position, neighbors);
        return spread.middle > kPatch * spread.largest ? Shown::plane : Shown::nothing_yet;
    };
    return widen(points, search, graph, std::move(rows), k, judge).left;
}

/// Of rows in noise as thick as their neighbours reach, until their plane is known; returns those
/// that have one.
std::vector<std::uint32_t> widen_in_noise(PointBlock& points, const NearestSearch& search,
                                          NeighborGraph& graph, std::vector<std::uint32_t> rows,
                                          std::size_t k) {
    const auto judge = [&](std::uint32_t, std::span<const std::uint32_t> neighbors,
                           Spread& spread) {
        spread = spread_of(points.position, neighbors);
        return is_doubtful(spread, neighbors.size()) ? Shown::nothing_yet : Shown::plane;
    };
    return widen(points, search, graph, std::move(rows), k, judge).found;
}

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

/// How many of the samples' neighbours lie in a plane, and of how many it is another one than that
/// of many more neighbours.
struct Strips {
    std::size_t n_flat = 0, n_off = 0;
};

Strips strips_of(const NearestSearch& search, std::span<const std::uint32_t> wanted,
                 std::size_t k) {
    std::vector<Spread> few(wanted.size()), many(wanted.size());
    const auto spreads = [&](std::size_t n, std::vector<Spread>& out) {
        search.for_each(wanted, n, [&](std::size_t w, std::span<const std::uint32_t> neighbors) {
            out[w] = spread_of(search.positions(), neighbors);
        });
    };
    spreads(k, few);
    spreads(std::min(kManyMore * k, kMostOfPatch), many);
    Strips found;
    for (std::size_t w = 0; w < wanted.size(); ++w) {
        const Spread& s = few[w];
        if (is_on_line(s) || !is_flat(s)) continue;
        ++found.n_flat;
        found.n_off += is_other_plane(s, many[w].normal);
    }
    return found;
}

}  // namespace

std::size_t neighbors_beyond_strips(const NearestSearch& search,
                                    std::span<const std::uint32_t> samples, std::size_t k) {
    std::vector<std::uint32_t> wanted(samples.begin(), samples.end());
    std::erase_if(wanted, [&](std::uint32_t i) { return search.is_repeat(i); });
    if (wanted.size() < kFewestStripSamples) return k;
    wanted.resize(std::min(wanted.size(), kStripSamples));
    std::sort(wanted.begin(), wanted.end());
    while (kManyMore * k <= search.size() && 2 * k <= kMostOfPatch) {
        const Strips found = strips_of(search, wanted, k);
        if (2 * found.n_flat < wanted.size() || 2 * found.n_off < found.n_flat) break;
        k *= 2;
    }
    return k;
}

NeighborGraph estimate_normals(PointBlock& points, const NearestSearch& search,
                               std::span<const std::uint32_t> wanted, std::size_t k,
                               std::size_t& degenerate, const std::vector<bool>& counted,
                               NoiseOfPoints noise) {
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
    std::vector<Kind> kinds(points.size());
    std::vector<std::uint8_t> doubtful(noise == NoiseOfPoints::thick ? rows.size() : 0);
    std::atomic<std::size_t> lines{0};
    search.for_each(searched, k, [&](std::size_t r, std::span<const std::uint32_t> neighbors) {
        const Spread spread = spread_of(points.position, neighbors);
        const bool counts = counted.empty() || counted[searched[r]];
        if (counts && !(spread.middle > kSpansPlane * spread.largest)) ++lines;
        kinds[searched[r]] = kind_of(spread);
        if (!doubtful.empty()) doubtful[r] = is_doubtful(spread, neighbors.size());
        points.normal[searched[r]] = normalized(to_float(spread.normal));
        list_neighbors(graph, rows[r], neighbors);
    });
    const std::vector<std::uint32_t> on_lines = rows_on_lines(graph, rows, kinds);
    const double farthest = on_lines.size() < rows.size() ? kFarthestOfFew : INFINITY;
    const std::vector<std::uint32_t> left =
        widen_lines(points, search, graph, on_lines, k, farthest);
    const auto count = [&](const std::vector<std::uint32_t>& some) {
        return static_cast<std::size_t>(
            std::count_if(some.begin(), some.end(), [&](std::uint32_t row) {
                return counted.empty() || counted[graph.points[row]];
            }));
    };
    graph.n_on_lines = count(left);
    std::vector<std::uint32_t> in_doubt;
    for (std::size_t r = 0; r < doubtful.size(); ++r)
        if (doubtful[r] && kinds[searched[r]] == Kind::patch) in_doubt.push_back(rows[r]);
    graph.n_widened = count(widen_in_noise(points, search, graph, std::move(in_doubt), k));
    degenerate = lines;
    copy_to_repeats(search, graph, points);
    return graph;
}

}  // namespace slim
