#include "slim/tree/tree_builder.h"

#include "slim/base/error.h"
#include "slim/neighbors/knn.h"
#include "slim/neighbors/morton.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace slim {
namespace {

constexpr std::uint32_t kRoot = kNoNode;

/// Surfels by level, children by parent; indices are those of the input.
class Linker {
public:
    Linker(std::span<const FittedSurfel> surfels, TreeCounts& counts)
        : surfels_(surfels), counts_(counts), parent_(surfels.size(), kRoot) {}

    /// The parent of every surfel, kRoot for the top; childless internal surfels are marked dropped.
    void link() {
        std::vector<std::uint32_t> above;  // internal surfels of the nearest level that has any
        for (int level = 1; level <= 255; ++level) {
            const std::vector<std::uint32_t> here = of_level(level);
            if (!above.empty() && !here.empty()) link_level(above, here);
            std::vector<std::uint32_t> internal;
            for (const std::uint32_t i : here)
                if (!(surfels_[i].flags & kLeaf)) internal.push_back(i);
            if (!internal.empty()) above = std::move(internal);
        }
    }
    const std::vector<std::uint32_t>& parents() const { return parent_; }

private:
    std::vector<std::uint32_t> of_level(int level) const {
        std::vector<std::uint32_t> out;
        for (std::uint32_t i = 0; i < surfels_.size(); ++i)
            if (surfels_[i].level == level) out.push_back(i);
        return out;
    }
    void link_level(const std::vector<std::uint32_t>& above,
                    const std::vector<std::uint32_t>& here) {
        std::vector<Vec3d> centers, queries;
        for (const std::uint32_t i : above) centers.push_back(surfels_[i].surfel.center);
        for (const std::uint32_t i : here) queries.push_back(surfels_[i].surfel.center);
        std::vector<std::uint32_t> found;
        std::vector<double> sq_distances;
        KnnIndex(centers).search(queries, 1, found, sq_distances);
        for (std::size_t i = 0; i < here.size(); ++i) {
            parent_[here[i]] = above[found[i]];
            const double rho = surfels_[above[found[i]]].surfel.support_radius;
            counts_.orphans += sq_distances[i] > rho * rho;
        }
    }

    std::span<const FittedSurfel> surfels_;
    TreeCounts& counts_;
    std::vector<std::uint32_t> parent_;
};

/// Children lists in one array: children of i are [begin[i], begin[i + 1]); the root is the last.
struct Families {
    std::vector<std::uint32_t> begin, child;
};

Families families_of(std::span<const FittedSurfel> surfels,
                     const std::vector<std::uint32_t>& parent, const Bbox& box) {
    const std::size_t n = surfels.size();
    const MortonCurve curve(box);
    std::vector<std::pair<std::uint64_t, std::uint32_t>> order(n);
    for (std::uint32_t i = 0; i < n; ++i) order[i] = {curve.key(surfels[i].surfel.center), i};
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
std::vector<bool> keep_fruitful(std::span<const FittedSurfel> surfels,
                                const std::vector<std::uint32_t>& parent, TreeCounts& counts) {
    std::vector<bool> kept(surfels.size(), false);
    for (std::uint32_t i = 0; i < surfels.size(); ++i)
        if (surfels[i].flags & kLeaf)
            for (std::uint32_t k = i; k != kRoot && !kept[k]; k = parent[k]) kept[k] = true;
    counts.childless += static_cast<std::uint64_t>(std::count(kept.begin(), kept.end(), false));
    return kept;
}

/// Node order: the root, then every family as one run, depth first.
struct Layout {
    std::vector<std::uint32_t> surfel_of;  // node -> input surfel, kRoot for node 0
    std::vector<TreeNode> nodes;
};

Layout lay_out(const Families& families, const std::vector<bool>& kept, std::size_t n) {
    Layout out;
    out.surfel_of.push_back(kRoot);
    out.nodes.emplace_back();
    std::vector<std::uint32_t> stack{0};
    while (!stack.empty()) {
        const std::uint32_t node = stack.back();
        stack.pop_back();
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
        for (std::uint32_t c = count; c-- > 0;) stack.push_back(first + c);
    }
    return out;
}

float round_up(double x) {
    const auto f = static_cast<float>(x);
    return std::nextafter(static_cast<double>(f) < x ? std::nextafter(f, INFINITY) : f, INFINITY);
}

/// Bound radii from the leaves up: children come after their parents. Centres as the file stores them.
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
Surfel enclosing_ball(std::span<const FittedSurfel> surfels, const Bbox& box) {
    Surfel root{box.center(), 0, frame_from_normal(Vec3d{0, 0, 1}), {}, 0};
    for (const FittedSurfel& s : surfels)
        root.support_radius =
            std::max(root.support_radius,
                     length(s.surfel.center - root.center) + s.surfel.support_radius);
    // Room for the rounding of centres to floats.
    root.support_radius *= 1 + 1e-6;
    return root;
}

}  // namespace

SurfelTreeData build_tree(std::span<const FittedSurfel> surfels, const ModelHeader& header,
                          TreeCounts& counts) {
    SurfelTreeData out;
    out.header = header;
    out.header.n_leaves = 0;
    Bbox box;
    for (const FittedSurfel& s : surfels) {
        box.extend(s.surfel.center);
        out.header.n_leaves += (s.flags & kLeaf) ? 1u : 0u;
    }
    if (out.header.n_leaves == 0) throw DataError("the fit left no surfel: nothing to build a model of");

    Linker linker(surfels, counts);
    linker.link();
    const std::vector<bool> kept = keep_fruitful(surfels, linker.parents(), counts);
    Layout layout = lay_out(families_of(surfels, linker.parents(), box), kept, surfels.size());

    std::vector<Surfel> ordered{enclosing_ball(surfels, box)};
    for (std::size_t i = 1; i < layout.nodes.size(); ++i) {
        const FittedSurfel& s = surfels[layout.surfel_of[i]];
        ordered.push_back(s.surfel);
        TreeNode& node = layout.nodes[i];
        node.fit_error = static_cast<float>(s.fit_error);
        node.n_points = s.n_points;
        node.level = s.level;
        node.degree = static_cast<std::uint8_t>(s.surfel.degree);
        node.flags = static_cast<std::uint8_t>(s.flags | (s.surfel.sharp ? kSharp : 0));
    }
    out.nodes = std::move(layout.nodes);
    encode_surfels(ordered, out);
    set_bounds(out);
    return out;
}

}  // namespace slim
