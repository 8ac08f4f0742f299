#include "slim/base/parallel.h"
#include "slim/cover/level_cover.h"
#include "slim/cover/level_cover_run.h"
#include "slim/fit/edge_share.h"
#include "slim/fit/points_on_faces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace slim {
namespace {

/// The box of points.
Bbox box_of(const PointBlock& points) {
    constexpr std::size_t kGrain = 65536;
    std::vector<Bbox> parts((points.size() + kGrain - 1) / kGrain);
    parallel_blocks(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        Bbox box;
        for (std::size_t i = begin; i < end; ++i) box.extend(points.position[i]);
        parts[begin / kGrain] = box;
    });
    Bbox box;
    for (const Bbox& part : parts) box.extend(part);
    return box;
}

EdgeQuestion edge_question(const CoverRules& rules, std::size_t n_here) {
    const double n = static_cast<double>(n_here) / rules.share;
    return {.spacing = rules.spacing,
            .n_points = rules.n_points > 0 ? static_cast<double>(rules.n_points) : n,
            .noise_variance = rules.noise_variance,
            .typical_variance = rules.typical_variance,
            .contrary_share = rules.ladder.contrary_share};
}

/// contrary_share, at most, of a part whose points were moved onto its faces: what poor normals it
/// has left stay at edges (as of smoothed clouds, slim/smooth/notes/0011).
constexpr double kContraryOnFaces = 0.002;

PartNoise part_noise(const CoverRules& rules) {
    return {rules.noise_variance, rules.typical_variance, rules.spacing};
}

/// The rules of points that lie on their faces. Neighbours err alike there: nothing follows what
/// the points or the normals of one place say.
CoverRules rules_on_faces(CoverRules rules) {
    const PartNoise left = part_noise(rules).left();
    rules.noise_variance = left.variance;
    rules.typical_variance = left.typical_variance;
    rules.ladder.contrary_share = std::min(rules.ladder.contrary_share, kContraryOnFaces);
    rules.follow_normals = rules.refits = false;
    return rules;
}

/// Normals made from neighbours turn smoothly over an edge: nothing parts its faces (notes/0024 of
/// slim/fit).
bool is_part_in_noise(const CoverRules& rules) {
    return rules.sharp && !rules.windows && !rules.are_estimated &&
           part_noise(rules).is_everywhere();
}

/// As cover_points(), where the rules say whether edges are looked for.
/// pyramid: of the points; given back where others take their place.
Cover cover_decided(const PointBlock& points, std::optional<PointPyramid>& pyramid,
                    const CoverRules& rules, Reporter& reporter) {
    if (!is_part_in_noise(rules)) return LevelCover(points, rules, *pyramid).run(reporter);
    pyramid.reset();
    // the points of a sample are farther apart
    const double reach = part_noise(rules).reach() / std::sqrt(rules.share);
    const PointBlock on_faces = points_on_faces(points, reach);
    const CoverRules there = rules_on_faces(rules);
    const PointPyramid moved(on_faces, box_of(on_faces), rules.seed, rules.share);
    Cover cover = LevelCover(on_faces, there, moved).run(reporter);
    cover.are_on_faces = true;
    return cover;
}

}  // namespace

Cover cover_points(const PointBlock& points, const CoverRules& rules, Reporter& reporter) {
    std::optional<PointPyramid> pyramid(std::in_place, points, box_of(points), rules.seed,
                                        rules.share);
    if (!rules.ask_for_edges) return cover_decided(points, pyramid, rules, reporter);
    CoverRules decided = rules;
    const EdgeShare edges = edge_share(points, *pyramid, edge_question(rules, points.size()));
    decided.sharp = edges.are_features();
    Cover cover = cover_decided(points, pyramid, decided, reporter);
    cover.edges = edges;
    return cover;
}

}  // namespace slim
