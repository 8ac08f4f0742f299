#include "formats/face_sizes.h"

#include "formats/face_triangles.h"
#include "formats/joined_edges.h"
#include "slim/base/area_vector.h"
#include "slim/base/bbox.h"
#include "slim/base/joined_sets.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace slim {
namespace {

constexpr double kSharpTurn = 40 * M_PI / 180;  // more ends a region
constexpr double kFacetTurn = 12 * M_PI / 180;  // more may be an edge of its own
constexpr double kLeastTurn = 2 * M_PI / 180;   // less does not bend it
constexpr double kParallel = 0.966;             // cos 15 degrees: edges that run side by side
constexpr double kOneLine = 1e-4;               // of its length: nearer it is met in its middle
constexpr std::size_t kMostPaired = 2000;       // sharp edges of which each pair is looked at
constexpr double kSparseShare = 0.5;            // of a piece's area, in large faces

using Sides = std::span<const FaceEdges::Side>;

bool is_smooth(const FaceEdges& edges, const Sides& sides) {
    return sides.size() == 2 && edges.turn(sides[0], sides[1]) < kSharpTurn;
}

/// The number of each face's piece, and how many there are.
using Pieces = std::pair<std::vector<std::uint32_t>, std::size_t>;

Pieces joined_by_vertices(const FaceList& faces) {
    JoinedSets groups(faces.position.size());
    for (std::size_t f = 0; f < faces.size(); ++f)
        for (const std::uint32_t v : faces[f]) groups.join(faces[f][0], v);
    const auto [number, n] = groups.numbered();
    std::vector<std::uint32_t> out;
    for (std::size_t f = 0; f < faces.size(); ++f)
        out.push_back(faces[f].empty() ? 0 : number[faces[f][0]]);
    return {std::move(out), n};
}

Pieces joined_by_edges(const FaceList& faces, const FaceEdges& edges) {
    JoinedSets groups(faces.size());
    edges.for_each_edge([&](const Sides& sides) {
        for (const auto& side : sides) groups.join(sides[0].face, side.face);
    });
    return groups.numbered();
}

/// For each face, whether most of its piece is large faces.
std::vector<bool> find_sparse(const FaceList& faces, const Pieces& pieces, double large,
                              double large_share) {
    const auto& [piece, n] = pieces;
    std::vector<Bbox> box(n);
    std::vector<double> area(n), large_area(n), area_of(faces.size());
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const double size = length(area_vector(faces.position, faces[f])) / 2;
        if (!std::isfinite(size) || !(size > 0)) continue;
        area_of[f] = size, area[piece[f]] += size;
        for (const std::uint32_t v : faces[f]) box[piece[f]].extend(faces.position[v]);
    }
    std::vector<Vec3d> corners;
    for (std::size_t f = 0; f < faces.size(); ++f) {
        if (!(area_of[f] > 0)) continue;
        corners.clear();
        for (const std::uint32_t v : faces[f]) corners.push_back(faces.position[v]);
        const double least = std::min(large, large_share * box[piece[f]].diagonal());
        if (extent_of(corners) > least) large_area[piece[f]] += area_of[f];
    }
    std::vector<bool> out(faces.size());
    for (std::size_t f = 0; f < faces.size(); ++f)
        out[f] = area_of[f] > 0 && large_area[piece[f]] > kSparseShare * area[piece[f]];
    return out;
}

/// Twice the area over the outline of each region; infinite without one.
std::vector<double> widths(const FaceList& faces, const FaceEdges& edges,
                           const std::vector<std::uint32_t>& region, std::size_t n) {
    std::vector<double> area(n), outline(n);
    for (std::size_t f = 0; f < faces.size(); ++f) area[region[f]] += edges.area(f);
    edges.for_each_edge([&](const Sides& sides) {
        if (is_smooth(edges, sides)) return;
        for (const auto& side : sides) outline[region[side.face]] += edges.length_of(side);
    });
    for (std::size_t r = 0; r < n; ++r) area[r] = 2 * area[r] / outline[r];
    return area;
}

/// A sharp edge, with the regions that meet there.
struct SharpEdge {
    Vec3d from, to;
    std::uint32_t piece;
    std::vector<std::uint32_t> regions;
};

/// Those of faces of sparse pieces, in the order of for_each_edge; none if there are too many to
/// look at each pair.
std::vector<SharpEdge> sharp_edges(const FaceList& faces, const FaceEdges& edges,
                                   const std::vector<bool>& sparse,
                                   const std::vector<std::uint32_t>& piece,
                                   const std::vector<std::uint32_t>& region) {
    std::vector<SharpEdge> sharp;
    edges.for_each_edge([&](const Sides& sides) {
        if (!sparse[sides[0].face] || is_smooth(edges, sides) || sharp.size() > kMostPaired) return;
        sharp.push_back({faces.position[sides[0].a], faces.position[sides[0].b],
                         piece[sides[0].face], {}});
        for (const auto& side : sides) sharp.back().regions.push_back(region[side.face]);
    });
    if (sharp.size() > kMostPaired) sharp.clear();
    return sharp;
}

bool share_a_region(const SharpEdge& a, const SharpEdge& b) {
    return std::find_first_of(a.regions.begin(), a.regions.end(), b.regions.begin(),
                              b.regions.end()) != a.regions.end();
}

/// How far apart two edges run side by side; infinite if they do not.
double apart(const SharpEdge& a, const SharpEdge& b) {
    const Vec3d along = a.to - a.from, other = b.to - b.from;
    const double sq = sq_length(along);
    if (!(std::abs(dot(along, other)) > kParallel * std::sqrt(sq * sq_length(other))))
        return std::numeric_limits<double>::infinity();
    const double s = dot(b.from - a.from, along) / sq, t = dot(b.to - a.from, along) / sq;
    const double begin = std::max(0.0, std::min(s, t)), end = std::min(1.0, std::max(s, t));
    if (!(begin < end)) return std::numeric_limits<double>::infinity();
    const double middle = (begin + end) / 2, at = (middle - s) / (t - s);
    return length(a.from + middle * along - b.from - at * other);
}

/// How far each edge is from the nearest that runs beside it and bounds no region with it: the
/// outer and the hollow edge of an angle profile are as near as its webs are thin.
std::vector<double> thicknesses(const std::vector<SharpEdge>& edges) {
    std::vector<double> out(edges.size(), std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < edges.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            if (edges[i].piece != edges[j].piece || share_a_region(edges[i], edges[j])) continue;
            const double d = apart(edges[i], edges[j]);
            const double longer = std::max(length(edges[i].to - edges[i].from),
                                           length(edges[j].to - edges[j].from));
            if (d > kOneLine * longer)
                out[i] = std::min(out[i], d), out[j] = std::min(out[j], d);
        }
    return out;
}

}  // namespace

double SizedEdge::distance(const Vec3d& p) const {
    const Vec3d along = to - from;
    const double t = std::clamp(dot(p - from, along) / sq_length(along), 0.0, 1.0);
    return length(p - from - t * along);
}

FaceSizes::FaceSizes(const FaceList& faces, double large, double large_share) {
    // Pieces that share vertices are found soon, and are one in most scans.
    std::vector<bool> sparse = find_sparse(faces, joined_by_vertices(faces), large, large_share);
    if (std::find(sparse.begin(), sparse.end(), true) == sparse.end()) {
        region_.resize(faces.size()), begin_.resize(2);
        return;
    }
    const FaceEdges edges(faces);
    const Pieces pieces = joined_by_edges(faces, edges);
    sparse = find_sparse(faces, pieces, large, large_share);
    JoinedSets groups(faces.size());
    edges.for_each_edge([&](const Sides& sides) {
        if (is_smooth(edges, sides)) groups.join(sides[0].face, sides[1].face);
    });
    std::size_t n = 0;
    std::tie(region_, n) = groups.numbered();
    const std::vector<double> width = widths(faces, edges, region_, n);

    std::vector<std::vector<SizedEdge>> found(n);  // of each region
    const auto add = [&](const Sides& sides, double size) {
        const SizedEdge edge{faces.position[sides[0].a], faces.position[sides[0].b], size};
        std::uint32_t last = std::numeric_limits<std::uint32_t>::max();
        for (const auto& side : sides)
            if (std::exchange(last, region_[side.face]) != region_[side.face])
                found[region_[side.face]].push_back(edge);
    };
    const std::vector<double> thickness =
        thicknesses(sharp_edges(faces, edges, sparse, pieces.first, region_));
    std::size_t next = 0;  // of the sharp ones
    edges.for_each_edge([&](const Sides& sides) {
        if (!sparse[sides[0].face]) return;
        if (!is_smooth(edges, sides)) {
            double size = next < thickness.size() ? thickness[next++]
                                                  : std::numeric_limits<double>::infinity();
            for (const auto& side : sides) size = std::min(size, width[region_[side.face]]);
            add(sides, size);
        } else if (const double turn = edges.turn(sides[0], sides[1]); turn > kLeastTurn) {
            const double facet = (edges.width(sides[0]) + edges.width(sides[1])) / 2;
            add(sides, turn < kFacetTurn ? facet / turn : facet);
        }
    });
    begin_.push_back(0);
    for (const std::vector<SizedEdge>& of_region : found) {
        const std::vector<SizedEdge> few = joined_edges(of_region);
        edges_.insert(edges_.end(), few.begin(), few.end());
        begin_.push_back(edges_.size());
    }
}

}  // namespace slim
