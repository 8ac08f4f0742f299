#include "slim/smooth/feature_edges.h"

#include "slim/base/area_vector.h"
#include "slim/base/parallel.h"
#include "slim/cover/leaf_maker.h"
#include "slim/neighbors/point_pyramid.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace slim {
namespace {

constexpr std::size_t kRound = 128, kMost = 512;
constexpr std::size_t kLeastPoints = 60;  ///< of a fold of a scan fewer
                                          ///< agree, of a part's edge more
constexpr double kLeastShare = 0.08;      ///< parts: 9.0 % and more; scans and
                                          ///< heads: 5.3 % and less (notes/0008)
constexpr double kFacets = 0.866;         ///< cosine of normals: rows of vertices of one
                                          ///< normal, as bends have, make flat facets
constexpr double kSure = 3;               ///< standard errors
constexpr std::size_t kGrain = 8;

/// Vertices with the normals of the faces about them, by area; those without any are left out.
PointBlock vertices_of(const Mesh& mesh) {
    std::vector<Vec3d> normal(mesh.position.size());
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        const Vec3d area = area_vector(mesh.position, mesh.face(f));
        for (const std::uint32_t v : mesh.face(f)) normal[v] += area;
    }
    PointBlock out;
    for (std::size_t v = 0; v < normal.size(); ++v) {
        const Vec3d n = normalized(normal[v]);
        if (!is_finite(mesh.position[v]) || !is_finite(n) || !(sq_length(n) > 0)) continue;
        out.position.push_back(mesh.position[v]);
        out.normal.push_back(to_float(n));
        out.id.push_back(v);
    }
    return out;
}

/// As a build has them, less what is of leaves that are made (LeafMaker::make) and not of the
/// search: the typical noise has no part in it, so that lambda stands in.
CoverRules rules_of(const SmoothModelRules& model) {
    CoverRules rules;
    rules.degree = model.degree;
    rules.ladder.choose_degree = model.choose_degree;
    rules.mdl_threshold = model.mdl_threshold;
    rules.diagonal = model.diagonal;
    rules.noise_variance = rules.typical_variance = model.noise_variance;
    rules.ladder.contrary_share = model.contrary_share;
    rules.spacing = model.spacing;
    rules.least_radius = model.diagonal * std::numeric_limits<double>::epsilon();
    rules.sharp = true;
    return rules;
}

/// Whether no two of the sheets are facets of a bend.
bool is_edge(const Surfel& s) {
    for (std::size_t a = 1; a < s.n_sheets(); ++a)
        for (std::size_t b = 0; b < a; ++b)
            if (dot(s.sheet_frame(a).normal, s.sheet_frame(b).normal) > kFacets) return false;
    return s.n_sheets() > 1;
}

bool is_sure(const EdgesSeen& seen) {
    const double n = static_cast<double>(seen.asked), p = std::max(seen.share(), 1 / n);
    return std::abs(seen.share() - kLeastShare) > kSure * std::sqrt(p * (1 - p) / n);
}

}  // namespace

bool EdgesSeen::are_features() const { return share() > kLeastShare; }

EdgesSeen feature_edges(const Mesh& mesh, const SmoothModelRules& model) {
    constexpr std::uint64_t kSeed = 0;
    EdgesSeen seen;
    PointBlock points = vertices_of(mesh);
    if (points.empty()) return seen;
    Bbox box;
    for (const Vec3d& p : points.position) box.extend(p);
    sort_along_curve(points, box);
    const PointPyramid pyramid(points, box, kSeed);
    const CoverRules rules = rules_of(model);
    const LeafMaker maker(points, rules, pyramid);
    const std::size_t n = std::min(kMost, points.size());
    std::vector<std::uint8_t> at_edge(n);
    while (seen.asked < n && (seen.asked == 0 || !is_sure(seen))) {
        const std::size_t first = seen.asked, last = std::min(n, first + kRound);
        parallel_blocks(last - first, kGrain, [&](std::size_t begin, std::size_t end) {
            LeafWork work;
            for (std::size_t i = first + begin; i < first + end; ++i) {
                LeafCandidate c;
                c.point = pyramid.by_priority()[i];
                maker.choose(c, work);
                const FittedSurfel& found = c.surfel.fitted;
                at_edge[i] = found.n_points >= kLeastPoints && is_edge(found.surfel);
            }
        });
        seen.asked = last;
        seen.at_edges = static_cast<std::size_t>(std::count(at_edge.begin(), at_edge.end(), 1));
    }
    return seen;
}

}  // namespace slim
