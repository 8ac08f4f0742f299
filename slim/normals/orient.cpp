#include "slim/normals/orient.h"

#include "slim/normals/outside.h"
#include "slim/normals/sign_groups.h"
#include "slim/normals/sign_merge.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace slim {
namespace {

constexpr float kSteep = 0.5f;  // |n_z| of a slope of 60 degrees
// share of points less steep in a scene that is seen from above
constexpr double kMostlyFlat = 0.8;
// |sum of normals| over their number of a shape that is closed but for small holes: of a bowl 0.5
constexpr double kSmallHole = 0.25;
// hints on a component's side less those on the other, of all: enough to outweigh a closed shape
// (85 % are on one side), or where the shape says little
constexpr double kSureHints = 0.7, kFairHints = 0.1;

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
};

/// What a component looks like.
struct Shape {
    Vec3d centroid;
    Vec3d normals;  ///< their sum
    double n = 0, flux = 0, reach = 0;
    double hints = 0;  ///< of the normals that hint, and how many
    double n_hints = 0;

    /// Unlike coins that are thrown (four standard deviations), and clear enough.
    bool has_hints(double least) const {
        return std::abs(hints) > std::max(4 * std::sqrt(n_hints), least * n_hints);
    }
};

std::vector<Shape> shapes_of(const PointBlock& points, const Components& components,
                             const std::optional<Vec3d>& center,
                             std::span<const Vec3f> hints) {
    std::vector<Shape> shapes(components.n);
    for (std::size_t i = 0; i < points.size(); ++i) {
        Shape& s = shapes[components.of[i]];
        s.centroid += points.position[i];
        s.n += 1;
    }
    for (Shape& s : shapes) s.centroid = center.value_or(s.centroid * (1 / std::max(s.n, 1.0)));
    for (std::size_t i = 0; i < points.size(); ++i) {
        Shape& s = shapes[components.of[i]];
        const double sign = components.opposed[i] ? -1 : 1;
        const Vec3d arm = points.position[i] - s.centroid;
        const Vec3d n = to_double(points.normal[i]) * sign;
        s.flux += dot(arm, n);
        s.reach += length(arm);
        s.normals += n;
        if (!hints.empty() && sq_length(hints[i]) > 0) {
            s.hints += dot(to_double(hints[i]), n) < 0 ? -1 : 1;
            s.n_hints += 1;
        }
    }
    return shapes;
}

bool has_outside(const Shape& s) { return std::abs(s.flux) > kClearFlux * s.reach; }

bool is_closed(const Shape& s) { return has_outside(s) && length(s.normals) < kSmallHole * s.n; }

/// A scene whose main part has no outside is a terrain or a wall: all its parts are seen from one
/// side.
bool is_flat_scene(const std::vector<Shape>& shapes) {
    const auto largest = std::max_element(shapes.begin(), shapes.end(), [](auto& a, auto& b) {
        return a.n < b.n;
    });
    return largest != shapes.end() && !has_outside(*largest);
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
                                 std::vector<bool>& known, const std::optional<Vec3d>& center,
                                 std::span<const Vec3f> hints,
                                 const std::vector<bool>& counted, bool seen_from_above) {
    SignGroups groups = group_by_sign(points, graph, known);
    std::vector<SignVote> votes = votes_between(points, graph, groups);
    graph.neighbors = {};
    SignedForest forest = merge_by_votes(groups.n, std::move(votes));
    const Components components(std::move(groups), std::move(forest));
    const std::vector<Shape> shapes = shapes_of(points, components, center, hints);
    const bool flat = is_flat_scene(shapes);
    const bool from_above = (flat || seen_from_above) && is_seen_from_above(points, graph.points);

    OrientReport report;
    report.from_above = from_above;
    report.components = components.n - 1;
    for (const std::uint32_t i : graph.points) {
        if (known[i]) continue;
        const Shape& s = shapes[components.of[i]];
        const bool is_anchored = components.of[i] == Components::kKnown;
        const bool has_shape = !flat && has_outside(s);
        const bool is_clear = (has_shape && is_closed(s)) || from_above;
        const bool is_hinted = s.has_hints(is_clear ? kSureHints : kFairHints);
        const double vote = is_anchored ? 1
                            : is_hinted ? s.hints
                            : has_shape ? s.flux
                                        : s.normals.z;
        bool turn = (vote < 0) != (components.opposed[i] != 0);
        // An airborne scanner sees no overhang, whatever the votes say of a tree or a shed.
        if (from_above && (seen_from_above || !is_anchored) && !is_hinted &&
            std::abs(points.normal[i].z) > kSteep)
            turn = points.normal[i].z < 0;
        if (turn) points.normal[i] = -points.normal[i];
        const bool counts = counted.empty() || counted[i];
        (is_anchored ? report.by_neighbors : report.by_rule) += counts;
        report.by_hints += counts && !is_anchored && is_hinted;
        known[i] = true;
    }
    return report;
}

}  // namespace slim
