#include "slim/tree/tree_builder.h"

#include "slim/base/check.h"
#include "slim/base/error.h"
#include "slim/model/surfel_encoder.h"
#include "slim/neighbors/morton.h"
#include "slim/tree/ball_links.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

namespace slim {
namespace {

constexpr std::uint32_t kRoot = kNoNode;

using Ball = LinkedBall;

std::vector<Ball> balls_of(const SurfelSource& source, std::size_t n) {
    std::vector<Ball> balls;
    balls.reserve(n);
    source([&](const FittedSurfel& s) {
        const SurfelShape shape = shape_of(s.surfel);
        balls.push_back(
            {shape.center, s.surfel.support_radius, s.level, s.flags, shape.degree, shape.n_extra});
    });
    SLIM_CHECK(balls.size(), ==, n);
    return balls;
}

/// Children lists in one array: children of i are [begin[i], begin[i + 1]); the root is the last.
struct Families {
    std::vector<std::uint32_t> begin, child;
};

Families families_of(std::span<const Ball> balls, const std::vector<std::uint32_t>& parent,
                     const Bbox& box) {
    const std::size_t n = balls.size();
    const MortonCurve curve(box);
    std::vector<std::pair<std::uint64_t, std::uint32_t>> order(n);
    for (std::uint32_t i = 0; i < n; ++i) order[i] = {curve.key(balls[i].center), i};
    std::sort(order.begin(), order.end());
    const auto slot = [&](std::uint32_t p) { return p == kRoot ? n : std::size_t{p}; };
    Families f;
    f.begin.assign(n + 2, 0);
    for (const std::uint32_t p : parent) ++f.begin[slot(p) + 1];
    for (std::size_t i = 1; i < f.begin.size(); ++i) f.begin[i] += f.begin[i - 1];
    f.child.resize(n);
    std::vector<std::uint32_t> at(f.begin.begin(), f.begin.end() - 1);
    for (const auto& [key, i] : order) f.child[at[slot(parent[i])]++] = i;
    return f;
}

/// Keeps leaves and what has one below; `kept[i]` of the input.
std::vector<bool> keep_fruitful(std::span<const Ball> balls,
                                const std::vector<std::uint32_t>& parent, TreeCounts& counts) {
    std::vector<bool> kept(balls.size(), false);
    for (std::uint32_t i = 0; i < balls.size(); ++i)
        if (balls[i].flags & kLeaf)
            for (std::uint32_t k = i; k != kRoot && !kept[k]; k = parent[k]) kept[k] = true;
    counts.childless += static_cast<std::uint64_t>(std::count(kept.begin(), kept.end(), false));
    return kept;
}

/// Node order: the root, then generation by generation, families in the order of their parents:
/// what a view shows from afar is the front of the file, what it shows of a part are some runs of
/// each generation (notes/0005).
struct Layout {
    std::vector<std::uint32_t> surfel_of;  // node -> input surfel, kRoot for node 0
    std::vector<TreeNode> nodes;
};

Layout lay_out(const Families& families, const std::vector<bool>& kept, std::size_t n) {
    Layout out;
    const auto n_nodes = 1 + static_cast<std::size_t>(std::count(kept.begin(), kept.end(), true));
    out.surfel_of.reserve(n_nodes);
    out.nodes.reserve(n_nodes);
    out.surfel_of.push_back(kRoot);
    out.nodes.emplace_back();
    for (std::size_t node = 0; node < out.nodes.size(); ++node) {
        const std::size_t slot = out.surfel_of[node] == kRoot ? n : out.surfel_of[node];
        const auto first = static_cast<std::uint32_t>(out.nodes.size());
        for (std::uint32_t c = families.begin[slot]; c < families.begin[slot + 1]; ++c) {
            if (!kept[families.child[c]]) continue;
            out.surfel_of.push_back(families.child[c]);
            out.nodes.emplace_back();
        }
        const auto count = static_cast<std::uint32_t>(out.nodes.size()) - first;
        if (count == 0) continue;
        out.nodes[node].first_child = first;
        out.nodes[node].n_children = count;
    }
    return out;
}

float round_up(double x) {
    const auto f = static_cast<float>(x);
    return std::nextafter(static_cast<double>(f) < x ? std::nextafter(f, INFINITY) : f, INFINITY);
}

/// Bound radii from the leaves up: children come after their parents. Centres as the file stores
/// them.
void set_bounds(SurfelTreeData& tree) {
    const SurfelTree view = tree.view();
    for (std::size_t i = tree.nodes.size(); i-- > 0;) {
        TreeNode& node = tree.nodes[i];
        double bound = view.support_radius(i);
        for (std::uint32_t c = 0; c < node.n_children; ++c) {
            const std::size_t child = node.first_child + c;
            bound = std::max(bound, length(view.center(child) - view.center(i)) +
                                        static_cast<double>(tree.nodes[child].bound_radius));
        }
        node.bound_radius = round_up(bound);
    }
}

/// The ball about all surfels, a surfel without a surface.
Surfel enclosing_ball(std::span<const Ball> balls, const Bbox& box) {
    Surfel root{box.center(), 0, frame_from_normal(Vec3d{0, 0, 1}), {}, 0};
    for (const Ball& b : balls)
        root.support_radius =
            std::max(root.support_radius, length(b.center - root.center) + b.support_radius);
    // Room for the rounding of centres to floats.
    root.support_radius *= 1 + 1e-6;
    return root;
}

/// Links the balls and lays the nodes out; nothing but the layout stays.
Layout lay_out_linked(std::span<const Ball> balls, const Bbox& box, TreeCounts& counts) {
    const auto [parent, n_orphans] = link_balls(balls);
    counts.orphans += n_orphans;
    const std::vector<bool> kept = keep_fruitful(balls, parent, counts);
    return lay_out(families_of(balls, parent, box), kept, balls.size());
}

/// node_of[surfel] from surfel_of[node]; kNoNode: left out.
std::vector<std::uint32_t> inverse(const std::vector<std::uint32_t>& surfel_of, std::size_t n) {
    std::vector<std::uint32_t> node_of(n, kNoNode);
    for (std::uint32_t node = 1; node < surfel_of.size(); ++node) node_of[surfel_of[node]] = node;
    return node_of;
}

void describe(const FittedSurfel& s, TreeNode& node) {
    node.fit_error = static_cast<float>(s.fit_error);
    node.n_points = s.n_points;
    SLIM_CHECK(s.level, <, 64);
    node.level = s.level & 63u;
    node.degree = static_cast<unsigned>(s.surfel.degree) & 3u;
    node.flags = static_cast<std::uint8_t>(s.flags | (s.surfel.sharp ? kSharp : 0));
}

/// Sends every surfel of the source to its node.
void put_surfels(const SurfelSource& source, const std::vector<std::uint32_t>& node_of,
                 SurfelEncoder& encoder, SurfelTreeData& out) {
    std::size_t next = 0;
    source([&](const FittedSurfel& s) {
        const std::uint32_t node = node_of.at(next++);
        if (node == kNoNode) return;
        describe(s, out.nodes[node]);
        out.nodes[node].set_rims(encoder.put(node, s.surfel));
    });
    SLIM_CHECK(next, ==, node_of.size());
}

}  // namespace

SurfelTreeData build_tree(const SurfelSource& source, std::size_t n, const ModelHeader& header,
                          TreeCounts& counts) {
    std::vector<Ball> balls = balls_of(source, n);
    SurfelTreeData out;
    out.header = header;
    out.header.n_leaves = 0;
    Bbox box;
    for (const Ball& b : balls) {
        box.extend(b.center);
        out.header.n_leaves += (b.flags & kLeaf) ? 1u : 0u;
    }
    if (out.header.n_leaves == 0)
        throw DataError("the fit left no surfel: nothing to build a model of");

    Layout layout = lay_out_linked(balls, box, counts);
    out.nodes = std::move(layout.nodes);
    const Surfel root = enclosing_ball(balls, box);
    SurfelEncoder encoder(
        out.nodes.size(),
        [&](std::size_t i) { return i == 0 ? shape_of(root) : balls[layout.surfel_of[i]].shape(); },
        out);
    // the largest part of the peak otherwise; "= {}" would keep it
    std::vector<Ball>().swap(balls);
    encoder.put(0, root);
    put_surfels(source, inverse(layout.surfel_of, n), encoder, out);
    set_bounds(out);
    return out;
}

SurfelTreeData build_tree(std::span<const FittedSurfel> surfels, const ModelHeader& header,
                          TreeCounts& counts) {
    return build_tree(source_of(surfels), surfels.size(), header, counts);
}

}  // namespace slim
