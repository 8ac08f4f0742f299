#include "slim/normals/orient.h"

#include "slim/base/parallel.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numeric>

namespace slim {
namespace {

constexpr std::size_t kGrain = 4096;  // rows of the graph a task
constexpr float kSteep = 0.5f;        // |n_z| of a slope of 60 degrees
// share of points less steep in a scene that is seen from above
constexpr double kMostlyFlat = 0.8;
// |sum (p - c) . n| / sum |p - c| of a shape that has an outside
constexpr double kClearFlux = 0.15;

/// Union-find whose members carry a sign relative to their root.
class SignedForest {
public:
    explicit SignedForest(std::size_t n) : parent_(n), flipped_(n, false), size_(n, 1) {
        std::iota(parent_.begin(), parent_.end(), 0u);
    }
    struct Root {
        std::uint32_t index;
        bool flipped;
    };
    Root find(std::uint32_t i) {
        std::uint32_t root = i;
        bool sign = false;
        while (parent_[root] != root) {
            sign ^= flipped_[root];
            root = parent_[root];
        }
        compress(i, root, sign);
        return {root, sign};
    }
    /// Joins the trees of a and b so that their signs differ iff `opposed`; false if joined before.
    bool join(std::uint32_t a, std::uint32_t b, bool opposed) {
        Root ra = find(a), rb = find(b);
        if (ra.index == rb.index) return false;
        if (size_[ra.index] < size_[rb.index]) std::swap(ra, rb);
        parent_[rb.index] = ra.index;
        flipped_[rb.index] = ra.flipped ^ rb.flipped ^ opposed;
        size_[ra.index] += size_[rb.index];
        return true;
    }

private:
    void compress(std::uint32_t i, std::uint32_t root, bool sign) {
        while (parent_[i] != root && i != root) {
            const std::uint32_t next = parent_[i];
            const bool own = flipped_[i];
            parent_[i] = root;
            flipped_[i] = sign;
            sign ^= own;
            i = next;
        }
    }
    std::vector<std::uint32_t> parent_;
    std::vector<bool> flipped_;
    std::vector<std::uint32_t> size_;
};

struct Edge {
    float weight;
    std::uint32_t a, b;
    bool operator<(const Edge& o) const {
        return weight != o.weight ? weight < o.weight : a != o.a ? a < o.a : b < o.b;
    }
};

float weight_of(const PointBlock& points, std::uint32_t a, std::uint32_t b) {
    return 1 - std::abs(dot(points.normal[a], points.normal[b]));
}

/// Kruskal's algorithm on classes of rising weight, so that no list of all edges is needed. Normals
/// within 2.6 degrees are joined as they come; of later classes only the edges between trees are
/// listed and sorted. (With 11 degrees 16 % of happy_stand_raw were turned the wrong way instead of
/// 7 %.)
constexpr float kClasses[] = {1e-3f, 2e-3f, 4e-3f, 0.01f, 0.03f, 0.1f, 0.3f, 2.0f};

void join_near_parallel(const PointBlock& points, const NeighborGraph& graph,
                        SignedForest& forest) {
    for (std::size_t row = 0; row < graph.points.size(); ++row) {
        const std::uint32_t i = graph.points[row];
        for (const std::uint32_t j : graph.of(row)) {
            const float cosine = dot(points.normal[i], points.normal[j]);
            if (1 - std::abs(cosine) < kClasses[0]) forest.join(i, j, cosine < 0);
        }
    }
}

/// The edges of rows [begin, end) of the graph with lo <= weight < hi that join two trees; tree: of
/// each point.
std::vector<Edge> edges_of_rows(const PointBlock& points, const NeighborGraph& graph,
                                const std::vector<std::uint32_t>& tree, float lo, float hi,
                                std::size_t begin, std::size_t end) {
    std::vector<Edge> edges;
    for (std::size_t row = begin; row < end; ++row) {
        const std::uint32_t i = graph.points[row];
        for (const std::uint32_t j : graph.of(row)) {
            if (tree[i] == tree[j]) continue;
            const float weight = weight_of(points, i, j);
            if (!(weight >= lo && weight < hi)) continue;
            if (j < i && graph.is_neighbor_too(j, i)) continue;  // once is enough
            edges.push_back({weight, i, j});
        }
    }
    return edges;
}

/// The edges with lo <= weight < hi that join two trees, lightest first.
std::vector<Edge> edges_between_trees(const PointBlock& points, const NeighborGraph& graph,
                                      SignedForest& forest, float lo, float hi) {
    std::vector<std::uint32_t> tree(points.size());
    for (std::uint32_t i = 0; i < tree.size(); ++i) tree[i] = forest.find(i).index;
    std::vector<std::vector<Edge>> parts((graph.points.size() + kGrain - 1) / kGrain);
    parallel_blocks(graph.points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        parts[begin / kGrain] = edges_of_rows(points, graph, tree, lo, hi, begin, end);
    });
    std::vector<Edge> edges;
    for (std::vector<Edge>& part : parts) {
        edges.insert(edges.end(), part.begin(), part.end());
        part = {};
    }
    tbb::parallel_sort(edges.begin(), edges.end());
    return edges;
}

SignedForest spanning_forest(const PointBlock& points, const NeighborGraph& graph) {
    SignedForest forest(points.size());
    join_near_parallel(points, graph, forest);
    for (std::size_t c = 1; c < std::size(kClasses); ++c)
        for (const Edge& e :
             edges_between_trees(points, graph, forest, kClasses[c - 1], kClasses[c]))
            forest.join(e.a, e.b, dot(points.normal[e.a], points.normal[e.b]) < 0);
    return forest;
}

/// The trees of the forest: which one each point is in, and whether its sign differs from the
/// root's.
struct Components {
    std::vector<std::uint32_t> of;
    std::vector<bool> flipped;
    std::size_t n = 0;

    explicit Components(SignedForest& forest, std::size_t n_points)
        : of(n_points), flipped(n_points) {
        constexpr std::uint32_t kNone = ~0u;
        std::vector<std::uint32_t> number(n_points, kNone);
        for (std::uint32_t i = 0; i < n_points; ++i) {
            const SignedForest::Root root = forest.find(i);
            if (number[root.index] == kNone) number[root.index] = static_cast<std::uint32_t>(n++);
            of[i] = number[root.index];
            flipped[i] = root.flipped;
        }
    }
};

/// What a component looks like, signs relative to its root.
struct Shape {
    Vec3d centroid;
    double n = 0, flux = 0, reach = 0, up = 0;
    std::int64_t votes = 0;  ///< of the points whose sign is known
    bool anchored = false;   ///< there are such
    double hints = 0;        ///< of the normals that hint, and how many
    double n_hints = 0;

    /// Unlike coins that are thrown (four standard deviations).
    bool has_clear_hints() const { return std::abs(hints) > 4 * std::sqrt(n_hints); }
};

std::vector<Shape> shapes_of(const PointBlock& points, const Components& components,
                             const std::vector<bool>& known, const std::optional<Vec3d>& center,
                             std::span<const Vec3f> hints) {
    std::vector<Shape> shapes(components.n);
    for (std::size_t i = 0; i < points.size(); ++i) {
        Shape& s = shapes[components.of[i]];
        s.centroid += points.position[i];
        s.n += 1;
    }
    for (Shape& s : shapes) s.centroid = center.value_or(s.centroid * (1 / s.n));
    for (std::size_t i = 0; i < points.size(); ++i) {
        Shape& s = shapes[components.of[i]];
        const double sign = components.flipped[i] ? -1 : 1;
        const Vec3d arm = points.position[i] - s.centroid;
        const Vec3d n = to_double(points.normal[i]) * sign;
        s.flux += dot(arm, n);
        s.reach += length(arm);
        s.up += n.z;
        if (!hints.empty() && sq_length(hints[i]) > 0) {
            s.hints += dot(to_double(hints[i]), n) < 0 ? -1 : 1;
            s.n_hints += 1;
        }
        if (!known[i]) continue;
        s.votes += components.flipped[i] ? -1 : 1;
        s.anchored = true;
    }
    return shapes;
}

bool has_outside(const Shape& s) { return std::abs(s.flux) > kClearFlux * s.reach; }

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

OrientReport orient_by_neighbors(PointBlock& points, const NeighborGraph& graph,
                                 std::vector<bool>& known, const std::optional<Vec3d>& center,
                                 std::span<const Vec3f> hints,
                                 const std::vector<bool>& counted, bool seen_from_above) {
    SignedForest forest = spanning_forest(points, graph);
    const Components components(forest, points.size());
    const std::vector<Shape> shapes = shapes_of(points, components, known, center, hints);
    const bool flat = is_flat_scene(shapes);
    const bool from_above = (flat || seen_from_above) && is_seen_from_above(points, graph.points);

    OrientReport report;
    report.from_above = from_above;
    for (const Shape& s : shapes) report.components += s.anchored ? 0 : 1;
    for (const std::uint32_t i : graph.points) {
        if (known[i]) continue;
        const Shape& s = shapes[components.of[i]];
        const double vote = s.anchored                 ? static_cast<double>(s.votes)
                            : s.has_clear_hints()     ? s.hints
                            : !flat && has_outside(s) ? s.flux
                                                      : s.up;
        bool turn = (vote < 0) != components.flipped[i];
        // An airborne scanner sees no overhang, whatever the forest says of a tree or a shed.
        if (from_above && (seen_from_above || !s.anchored) && !s.has_clear_hints() &&
            std::abs(points.normal[i].z) > kSteep)
            turn = points.normal[i].z < 0;
        if (turn) points.normal[i] = -points.normal[i];
        (s.anchored ? report.by_neighbors : report.by_rule) += counted.empty() || counted[i];
        known[i] = true;
    }
    return report;
}

}  // namespace slim
