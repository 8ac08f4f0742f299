#include "slim/normals/orient.h"

#include "slim/base/parallel.h"
#include "slim/normals/covariance.h"
#include "slim/normals/enclosure.h"
#include "slim/normals/outside.h"
#include "slim/normals/sign_groups.h"
#include "slim/normals/sign_merge.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace slim {
namespace {

constexpr std::size_t kGrain = 16384;  // points a task
constexpr float kSteep = 0.5f;  // |n_z| of a slope of 60 degrees
// share of points less steep in a scene that is seen from above
constexpr double kMostlyFlat = 0.8;
// hints on a component's side less those on the other, of all: enough to outweigh a closed shape
// (85 % are on one side), or where the shape says little
constexpr double kSureHints = 0.7, kFairHints = 0.1;
// the same of a sample that was oriented at once: where it is too coarse its signs are chance
constexpr double kFairSample = 0.5;

/// The parts of the cloud whose signs hang together: which one each point is in, and whether its
/// normal opposes the part's.
struct Components {
    static constexpr std::uint32_t kKnown = 0;  ///< with the points of known sign, if there are any

    std::vector<std::uint32_t> of;
    std::vector<std::uint8_t> opposed;
    std::size_t n = 1;

    Components(SignGroups groups, SignedForest forest)
        : of(std::move(groups.of)), opposed(std::move(groups.opposed)) {
        constexpr std::uint32_t kNone = ~0u;
        std::vector<std::uint32_t> number(groups.n, kNone);
        const SignedForest::Root known = forest.find(SignGroups::kKnown);
        number[known.index] = kKnown;
        for (std::size_t i = 0; i < of.size(); ++i) {
            const SignedForest::Root root = forest.find(of[i]);
            if (number[root.index] == kNone) number[root.index] = static_cast<std::uint32_t>(n++);
            of[i] = number[root.index];
            if (root.flipped != (of[i] == kKnown && known.flipped)) opposed[i] ^= 1;
        }
    }

    /// A point's normal on its component's side.
    Vec3d normal(const PointBlock& points, std::size_t i) const {
        return to_double(points.normal[i]) * (opposed[i] != 0 ? -1.0 : 1.0);
    }
};

/// What a component looks like.
struct Shape {
    Vec3d centroid;
    Vec3d normals;  ///< their sum
    double n = 0, flux = 0, reach = 0;
    double hints = 0;  ///< of the normals that hint, and how many
    double n_hints = 0;
    double sampled = 0, n_sampled = 0;  ///< the same of the sample of the whole
    bool reaches_out = false;           ///< of the slice
    double enclosed = 0;  ///< Enclosure's clear flux, where `flux` says nothing

    /// Unlike coins that are thrown (four standard deviations), and clear enough.
    bool has_hints(double least) const {
        return std::abs(hints) > std::max(4 * std::sqrt(n_hints), least * n_hints);
    }
};

bool has_clear_flux(const Shape& s) { return std::abs(s.flux) > kClearFlux * s.reach; }

bool has_outside(const Shape& s) { return has_clear_flux(s) || s.enclosed != 0; }

bool is_closed(const Shape& s) {
    return s.enclosed != 0 || (has_clear_flux(s) && length(s.normals) < kSmallHole * s.n);
}

/// Where the shapes lie, and which reach out of the slice.
std::vector<Shape> places_of(const PointBlock& points, const Components& components,
                             const std::optional<WholeScene>& whole,
                             const std::vector<bool>& counted) {
    std::vector<Shape> shapes(components.n);
    for (std::size_t i = 0; i < points.size(); ++i) {
        Shape& s = shapes[components.of[i]];
        s.centroid += points.position[i];
        s.n += 1;
        s.reaches_out |= !counted.empty() && !counted[i];
    }
    for (Shape& s : shapes)
        s.centroid = whole && s.reaches_out ? whole->center : s.centroid * (1 / std::max(s.n, 1.0));
    return shapes;
}

/// Which side a hint is on, +1 or -1.
double side(const Vec3f& hint, const Vec3d& normal) {
    return dot(to_double(hint), normal) < 0 ? -1 : 1;
}

std::vector<Shape> shapes_of(const PointBlock& points, const Components& components,
                             const std::optional<WholeScene>& whole, std::span<const Vec3f> hints,
                             const std::vector<bool>& counted) {
    std::vector<Shape> shapes = places_of(points, components, whole, counted);
    for (std::size_t i = 0; i < points.size(); ++i) {
        Shape& s = shapes[components.of[i]];
        const Vec3d arm = points.position[i] - s.centroid;
        const Vec3d n = components.normal(points, i);
        s.flux += dot(arm, n);
        s.reach += length(arm);
        s.normals += n;
        if (!hints.empty() && sq_length(hints[i]) > 0) s.hints += side(hints[i], n), s.n_hints += 1;
    }
    if (!whole) return shapes;
    for (const SampledNormal& sample : whole->sampled) {
        Shape& s = shapes[components.of[sample.point]];
        s.sampled += side(sample.normal, components.normal(points, sample.point));
        s.n_sampled += 1;
    }
    return shapes;
}

/// How far each point's farthest neighbour is: the square is as the area that it stands for; 0 of a
/// repeat.
std::vector<float> sizes_of(const PointBlock& points, const NeighborGraph& graph) {
    std::vector<float> sizes(points.size());
    parallel_blocks(graph.points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            const std::uint32_t i = graph.points[row];
            sizes[i] =
                static_cast<float>(std::sqrt(sq_reach_of(points.position, i, graph.of(row))));
        }
    });
    return sizes;
}

/// What those shapes enclose whose normals cancel, but whose flux is small beside their reach:
/// rods, rings, frames, plates.
void look_at_slender(const PointBlock& points, const Components& components,
                     std::span<const float> sizes, std::vector<Shape>& shapes) {
    std::vector<std::optional<Enclosure>> enclosures(shapes.size());
    for (std::size_t c = 0; c < shapes.size(); ++c) {
        const Shape& s = shapes[c];
        const bool cancels = length(s.normals) < 2 * kSmallHole * s.n;  // areas are unlike
        if (cancels && !has_clear_flux(s) && !s.reaches_out) enclosures[c].emplace();
    }
    for (std::size_t i = 0; i < points.size(); ++i)
        if (auto& e = enclosures[components.of[i]])
            e->measure(static_cast<double>(sizes[i]));
    for (std::size_t i = 0; i < points.size(); ++i)
        if (auto& e = enclosures[components.of[i]])
            e->add(points.position[i] - shapes[components.of[i]].centroid,
                   components.normal(points, i), static_cast<double>(sizes[i]));
    for (std::size_t c = 0; c < shapes.size(); ++c)
        if (enclosures[c]) shapes[c].enclosed = enclosures[c]->clear_flux();
}

/// A scene whose main part has no outside is a terrain or a wall: all its parts are seen from one
/// side.
bool is_flat_scene(const std::vector<Shape>& shapes) {
    const auto largest = std::max_element(shapes.begin(), shapes.end(), [](auto& a, auto& b) {
        return a.n < b.n;
    });
    return largest != shapes.end() && !has_outside(*largest);
}

/// Which side of a shape is out: where its normals stand if the vote is positive, else opposite.
struct Side {
    double vote = 0;
    bool is_hinted = false;
};

Side side_of(const Shape& s, const OrientReport& scene) {
    const bool is_object = is_closed(s) && !scene.from_above;  // also beside a terrain or a wall
    const bool has_flux = has_clear_flux(s) && (is_object || !scene.flat);
    const bool is_slender = is_object && s.enclosed != 0;
    const bool is_clear = (has_flux && is_closed(s)) || is_slender || scene.from_above;
    if (s.has_hints(is_clear ? kSureHints : kFairHints)) return {s.hints, true};
    if (s.reaches_out && std::abs(s.sampled) > kFairSample * s.n_sampled) return {s.sampled};
    if (is_slender) return {s.enclosed};
    return {has_flux ? s.flux : s.normals.z};
}

/// Whether most normals are nearer to the vertical than to the horizontal.
bool is_seen_from_above(const PointBlock& points, const std::vector<std::uint32_t>& wanted) {
    std::size_t n = 0;
    for (const std::uint32_t i : wanted) n += std::abs(points.normal[i].z) > kSteep ? 1 : 0;
    return static_cast<double>(n) > kMostlyFlat * static_cast<double>(wanted.size());
}

}  // namespace

std::size_t orient_to_sensors(PointBlock& points, std::span<const std::uint32_t> wanted,
                              std::span<const Vec3d> sensors) {
    std::size_t turned = 0;
    for (const std::uint32_t i : wanted) {
        const std::size_t scan = points.has_scans() ? points.scan[i] : 0;
        if (scan >= sensors.size() || !is_finite(sensors[scan])) continue;
        Vec3f& n = points.normal[i];
        if (dot(to_double(n), sensors[scan] - points.position[i]) < 0) n = -n;
        ++turned;
    }
    return turned;
}

OrientReport orient_by_neighbors(PointBlock& points, NeighborGraph graph,
                                 std::vector<bool>& known, const std::optional<WholeScene>& whole,
                                 std::span<const Vec3f> hints,
                                 const std::vector<bool>& counted, bool seen_from_above) {
    SignGroups groups = group_by_sign(points, graph, known);
    std::vector<SignVote> votes = votes_between(points, graph, groups);
    const std::vector<float> sizes = sizes_of(points, graph);
    graph.neighbors = {};
    SignedForest forest = merge_by_votes(groups.n, std::move(votes));
    const Components components(std::move(groups), std::move(forest));
    std::vector<Shape> shapes = shapes_of(points, components, whole, hints, counted);
    look_at_slender(points, components, sizes, shapes);

    OrientReport report;
    report.flat = whole && whole->has_sample ? whole->is_flat : is_flat_scene(shapes);
    report.from_above =
        (report.flat || seen_from_above) && is_seen_from_above(points, graph.points);
    report.components = components.n - 1;
    for (const std::uint32_t i : graph.points) {
        if (known[i]) continue;
        const Shape& s = shapes[components.of[i]];
        const bool is_anchored = components.of[i] == Components::kKnown;
        const Side side = side_of(s, report);
        bool turn = ((is_anchored ? 1 : side.vote) < 0) != (components.opposed[i] != 0);
        // An airborne scanner sees no overhang, whatever the votes say of a tree or a shed.
        if (report.from_above && (seen_from_above || !is_anchored) && !side.is_hinted &&
            std::abs(points.normal[i].z) > kSteep)
            turn = points.normal[i].z < 0;
        if (turn) points.normal[i] = -points.normal[i];
        const bool counts = counted.empty() || counted[i];
        (is_anchored ? report.by_neighbors : report.by_rule) += counts;
        report.by_hints += counts && !is_anchored && side.is_hinted;
        known[i] = true;
    }
    return report;
}

}  // namespace slim
