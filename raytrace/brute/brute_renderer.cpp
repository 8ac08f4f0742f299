#include "raytrace/brute/brute_renderer.h"

#include "slim/base/parallel.h"
#include "slim/blend/blend.h"
#include "slim/blend/leaf_hessians.h"

#include <chrono>
#include <vector>

namespace slim {
namespace {

struct Leaf {
    Surfel surfel;
    std::uint32_t node;
};

std::vector<Leaf> wanted_leaves(const SurfelTree& tree, bool loose, const LeafHessians& hessians,
                                RenderStats& stats) {
    std::vector<Leaf> leaves;
    for (std::size_t i = 0; i < tree.n_nodes(); ++i) {
        const TreeNode& node = tree.node(i);
        if (!node.is_leaf()) continue;
        if (!loose && node.is_loose()) {
            ++stats.loose_hidden;
            continue;
        }
        const auto id = static_cast<std::uint32_t>(i);
        leaves.push_back({tree.surfel(i), id});
        leaves.back().surfel.hessian = hessians.of(id);
    }
    return leaves;
}

struct FirstHit {
    double t = 0;
    const Leaf* leaf = nullptr;
    Vec3d gradient;
};

/// The nearest one behind `last`, if that has a leaf.
FirstHit nearest_hit(const Ray& ray, double t_near, const FirstHit& last,
                     const std::vector<const Leaf*>& row, RenderStats& stats) {
    FirstHit best;
    for (const Leaf* leaf : row) {
        Vec3d gradient;
        ++stats.root_tests;
        const double least =
            last.leaf ? last.t + kNextHit * leaf->surfel.support_radius : t_near;
        const auto t = first_hit(ray, leaf->surfel, least, hit_trim(leaf->surfel), gradient);
        if (t && (!best.leaf || *t < best.t)) best = {*t, leaf, gradient};
    }
    return best;
}

BlendSums blend_around(const Ray& ray, const FirstHit& hit, const std::vector<const Leaf*>& row,
                       bool sharp_model, Derivatives wanted, RenderStats& stats) {
    BlendSums sums;
    const Gate gate(hit.gradient, sharp_model);
    for (const Leaf* leaf : row) {
        ++stats.distance_tests;
        add_supporter(ray, hit.t, gate, leaf->surfel, wanted, sums);
    }
    return sums;
}

/// Whether a first hit does not count, as is_in_doubt and is_outvoted have it (slim/blend).
/// weight: sum G of its blend.
bool gives_way(const Ray& ray, const FirstHit& hit, double weight,
               const std::vector<const Leaf*>& row, bool sharp_model, RenderStats& stats) {
    if (!is_in_doubt(weight)) return false;
    double passing = 0;
    for (const Leaf* leaf : row) {
        ++stats.distance_tests;
        passing += passing_weight(ray, hit.t, Gate(hit.gradient, sharp_model), leaf->surfel);
    }
    return is_outvoted(weight, passing);
}

struct BlendedHit {
    FirstHit first;
    BlendSums sums;
};

/// The first hit, with clean outlines the first that is not outvoted.
BlendedHit blended_hit(const Ray& ray, double t_near, const std::vector<const Leaf*>& row,
                       bool sharp_model, bool clean_outlines, Derivatives wanted,
                       RenderStats& stats) {
    BlendedHit hit;
    for (int round = 0; round < kMostOutvoted; ++round) {
        hit.first = nearest_hit(ray, t_near, hit.first, row, stats);
        if (!hit.first.leaf) break;
        hit.sums = blend_around(ray, hit.first, row, sharp_model, wanted, stats);
        if (!clean_outlines || !gives_way(ray, hit.first, hit.sums.weight, row, sharp_model, stats))
            break;
    }
    return hit;
}

Derivatives derivatives_for(const GBuffer& out) {
    return out.has(kThirdOrderChannel)       ? Derivatives::third
           : out.has_any(kHessianChannels) ? Derivatives::second
                                           : Derivatives::first;
}

void write_directions(const BlendSums& sums, bool cubic, std::size_t pixel, GBuffer& out) {
    const ThirdOrder t = third_order_from(sums.gradient, sums.hessian, sums.third);
    const Vec3f t1 = to_float(t.t1);
    if (out.has(kDirectionChannel))
        for (std::size_t axis = 0; axis < 3; ++axis) out.direction[axis][pixel] = t1[axis];
    if (!cubic || !out.has(kThirdOrderChannel)) return;
    const double along[4] = {t.e1, t.k1_along_t2, t.k2_along_t1, t.e2};
    for (std::size_t i = 0; i < 4; ++i) out.third[i][pixel] = static_cast<float>(along[i]);
}

void write_pixel(const PixelView& view, const SurfelTree& tree, const Ray& ray, const FirstHit& hit,
                 const BlendSums& sums, std::size_t pixel, GBuffer& out) {
    const bool blended = sums.weight > 0;
    const double t = blended ? sums.t / sums.weight : hit.t;
    const Vec3d p = ray.origin + ray.direction * t;
    const Vec3f position = to_float(p);
    const Vec3f normal = to_float(normalized(blended ? sums.gradient : hit.gradient));
    out.hit[pixel] = 1;
    if (out.has(kDepthChannel))
        out.depth[pixel] = static_cast<float>(t * dot(ray.direction, view.forward));
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (out.has(kPositionChannel)) out.position[axis][pixel] = position[axis];
        if (out.has(kNormalChannel)) out.normal[axis][pixel] = normal[axis];
    }
    if (out.has_any(kCurvatureChannel) && blended) {
        const Curvature k = curvature_from(sums.gradient, sums.hessian);
        if (out.has(kK1Channel)) out.k1[pixel] = static_cast<float>(k.k1);
        if (out.has(kK2Channel)) out.k2[pixel] = static_cast<float>(k.k2);
        if (out.has(kMeanChannel)) out.mean[pixel] = static_cast<float>(k.mean);
        if (out.has(kGaussChannel)) out.gauss[pixel] = static_cast<float>(k.gauss);
    }
    if (out.has_any(kDirectionChannel | kThirdOrderChannel) && blended)
        write_directions(sums, tree.header().degree >= 3, pixel, out);
    const TreeNode& node = tree.node(hit.leaf->node);
    if (out.has(kSurfelIdChannel)) out.surfel_id[pixel] = hit.leaf->node;
    if (out.has(kFitErrorChannel)) out.fit_error[pixel] = node.fit_error;
    if (out.has(kLevelChannel)) out.level[pixel] = node.level;
    if (out.has(kCoverageChannel)) out.coverage[pixel] = static_cast<float>(sums.weight);
    if (out.has(kCountChannel)) out.count[pixel] = static_cast<std::uint32_t>(sums.count);
}

/// The leaves whose ball meets the plane that holds all rays of a row.
std::vector<const Leaf*> leaves_of_row(const PixelView& view, double py,
                                       const std::vector<Leaf>& leaves) {
    const Vec3d origin = view.ray_origin(view.center_x, py);
    const Vec3d normal =
        normalized(cross(view.right, view.ray_direction(view.center_x, py)));
    std::vector<const Leaf*> row;
    for (const Leaf& leaf : leaves) {
        const double distance = dot(normal, leaf.surfel.center - origin);
        if (std::abs(distance) <= leaf.surfel.support_radius * (1 + 1e-9)) row.push_back(&leaf);
    }
    return row;
}

void render_row(const PixelView& view, const PixelWindow& window, const SurfelTree& tree,
                const std::vector<Leaf>& leaves, bool clean_outlines, int y, GBuffer& out,
                RenderStats& stats) {
    const double py = window.y + y + 0.5;
    const auto row = leaves_of_row(view, py, leaves);
    for (int x = 0; x < window.width; ++x) {
        const double px = window.x + x + 0.5;
        const Ray ray{view.ray_origin(px, py), view.ray_direction(px, py)};
        const double t_near = view.near_plane / dot(ray.direction, view.forward);
        const auto [hit, sums] =
            blended_hit(ray, t_near, row, !tree.sharp().empty(), clean_outlines,
                        derivatives_for(out), stats);
        if (!hit.leaf) continue;
        write_pixel(view, tree, ray, hit, sums, out.index(x, y), out);
        ++stats.covered_pixels;
        if (!(sums.weight > 0)) ++stats.unblended_pixels;
    }
}

}  // namespace

RenderStats render_brute(const SurfelTree& tree, const RenderRequest& request, GBuffer& out) {
    const auto start = std::chrono::steady_clock::now();
    const PixelView view = pixel_view(request.camera, request.width, request.height);
    const PixelWindow window = request.resolved_window();
    out.reset(window.width, window.height, request.wanted);
    RenderStats stats;
    LeafHessians hessians(tree);
    if (out.has_any(kHessianChannels)) hessians.prepare_all();
    const std::vector<Leaf> leaves = wanted_leaves(tree, request.loose, hessians, stats);
    std::vector<RenderStats> rows(static_cast<std::size_t>(window.height));
    parallel_blocks(rows.size(), 1, [&](std::size_t y, std::size_t) {
        render_row(view, window, tree, leaves, request.clean_outlines, static_cast<int>(y), out,
                   rows[y]);
    });
    stats.nodes_visited = tree.n_nodes();
    stats.surfels_drawn = leaves.size();
    for (const RenderStats& r : rows) {
        stats.root_tests += r.root_tests;
        stats.distance_tests += r.distance_tests;
        stats.covered_pixels += r.covered_pixels;
        stats.unblended_pixels += r.unblended_pixels;
    }
    stats.total_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() -
                                                               start).count();
    stats.draw_ms = stats.total_ms;
    return stats;
}

}  // namespace slim
