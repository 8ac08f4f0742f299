#pragma once

#include "raytrace/brute/brute_renderer.h"
#include "raytrace/trace/trace_renderer.h"
#include "slim/base/hash.h"
#include "slim/blend/blend.h"
#include "tests/raytrace/support/analytic_models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>

namespace slim::test {

/// The picture of a model by rays.
inline GBuffer traced(const SurfelTreeData& model, const RenderRequest& request) {
    const SurfelTree tree = model.view();
    const ScenePart part{&tree, {}};
    GBuffer out;
    render_traced(TraceScene(std::span(&part, 1), request.loose), request, out);
    return out;
}

/// Pixels that differ from the reference's, by what they hold.
struct Difference {
    std::uint64_t covered = 0, hit = 0, depth = 0, normal = 0, curvature = 0, third = 0;
    std::uint64_t winner = 0;    ///< id
    std::uint64_t of_node = 0;   ///< level and fit error, which are to be those of the id
    std::uint64_t coverage = 0, count = 0;
};

/// Whether directions and derivatives differ, up to their common sign; not told where k1 is near
/// k2.
inline bool third_order_differs(const GBuffer& fast, const GBuffer& reference, std::size_t i) {
    const double k1 = reference.k1[i], k2 = reference.k2[i], size = 1 + std::abs(k1) + std::abs(k2);
    if (k1 - k2 < 0.05 * size) return false;
    double cos = 0, off = 0, third = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
        cos += static_cast<double>(fast.direction[axis][i] * reference.direction[axis][i]);
    for (std::size_t k = 0; k < 4; ++k) {
        const double a = fast.third[k][i], b = reference.third[k][i];
        off = std::max(off, std::abs(cos > 0 ? a - b : a + b));
        third = std::max(third, std::abs(b));
    }
    return std::abs(cos) < 1 - 1e-4 || off > 5e-3 * (size * size + third);
}

/// Whether one of the four curvatures differs by more than 1e-3 of the largest (Gauss:
/// of its square).
inline bool curvature_differs(const GBuffer& fast, const GBuffer& reference, std::size_t i) {
    const float size = 1 + std::max(std::abs(reference.k1[i]), std::abs(reference.k2[i]));
    for (const auto plane : {&GBuffer::mean, &GBuffer::k1, &GBuffer::k2})
        if (std::abs((fast.*plane)[i] - (reference.*plane)[i]) > 1e-3f * size) return true;
    return std::abs(fast.gauss[i] - reference.gauss[i]) > 2e-3f * size * size;
}

/// Whether the surfel that sets a pixel in one picture is hit as near as the one that does in the
/// other: which of them does is for rounding to say.
inline bool is_tie(const SurfelTree& tree, const PixelView& view, int x, int y, std::uint32_t a,
                   std::uint32_t b) {
    const double px = x + 0.5, py = y + 0.5;
    const Ray ray{view.ray_origin(px, py), view.ray_direction(px, py)};
    const double t_near = view.near_plane / dot(ray.direction, view.forward);
    Vec3d gradient;
    const auto t_a = first_hit(ray, tree.surfel(a), t_near, hit_trim(tree.surfel(a)), gradient),
               t_b = first_hit(ray, tree.surfel(b), t_near, hit_trim(tree.surfel(b)), gradient);
    return t_a && t_b &&
           std::abs(*t_a - *t_b) <= 1e-5 * tree.support_radius(b) + 2e-7 * std::abs(*t_b);
}

/// Pixels that differ: in the mask, or in position by more than 1e-5 of the winner's radius, and so
/// on. All channels must be there.
inline Difference difference(const SurfelTreeData& model, const RenderRequest& request,
                             const GBuffer& fast, const GBuffer& reference) {
    const PixelView view = pixel_view(request.camera, request.width, request.height);
    Difference d;
    for (std::size_t i = 0; i < fast.n_pixels(); ++i) {
        d.covered += reference.hit[i];
        if (fast.hit[i] != reference.hit[i]) {
            ++d.hit;
            continue;
        }
        if (!fast.hit[i]) continue;
        const Vec3d p{fast.position[0][i], fast.position[1][i], fast.position[2][i]};
        const Vec3d q{reference.position[0][i], reference.position[1][i], reference.position[2][i]};
        const double rho = model.view().support_radius(reference.surfel_id[i]);
        // The planes hold floats: two roundings of a coordinate come on top.
        const double rounding = 2e-7 * (length(q) + 1e-30);
        const double depth = static_cast<double>(reference.depth[i]);
        d.depth += std::abs(dot(p - q, view.forward)) > 1e-5 * rho + rounding ||
                   std::abs(static_cast<double>(fast.depth[i]) - depth) > 1e-5 * rho + 2e-7 * depth;
        const Vec3d n{fast.normal[0][i], fast.normal[1][i], fast.normal[2][i]};
        const Vec3d m{reference.normal[0][i], reference.normal[1][i], reference.normal[2][i]};
        d.normal += length(n - m) > 1e-3;
        d.curvature += curvature_differs(fast, reference, i);
        d.third += third_order_differs(fast, reference, i);
        const auto at = static_cast<int>(i);
        d.winner +=
            fast.surfel_id[i] != reference.surfel_id[i] &&
            !is_tie(model.view(), view, request.window.x + at % fast.width,
                    request.window.y + at / fast.width, fast.surfel_id[i], reference.surfel_id[i]);
        const TreeNode& node = model.nodes[fast.surfel_id[i]];
        d.of_node +=
            fast.level[i] != static_cast<float>(node.level) || fast.fit_error[i] != node.fit_error;
        d.coverage += std::abs(fast.coverage[i] - reference.coverage[i]) >
                      1e-3f * (1 + reference.coverage[i]);
        d.count += fast.count[i] != reference.count[i];
    }
    return d;
}

/// A picture against that of the reference renderer, in all channels.
inline void expect_like_brute(const SurfelTreeData& model, const RenderRequest& request,
                              const GBuffer& fast) {
    GBuffer reference;
    ASSERT_EQ(request.wanted, kAllChannels);
    render_brute(model.view(), request, reference);
    const Difference d = difference(model, request, fast, reference);
    const auto allowed = static_cast<double>(d.covered) * 1e-4 + 1;
    EXPECT_GT(d.covered, 100u);
    EXPECT_LE(static_cast<double>(d.hit + d.depth), allowed);
    EXPECT_LE(static_cast<double>(d.normal), allowed);
    EXPECT_LE(static_cast<double>(d.curvature), allowed);
    EXPECT_LE(static_cast<double>(d.third), 3 * allowed);
    EXPECT_LE(static_cast<double>(d.winner), allowed);
    EXPECT_EQ(d.of_node, 0u);
    EXPECT_LE(static_cast<double>(d.coverage), allowed);
    EXPECT_LE(static_cast<double>(d.count), allowed);
}

inline RenderRequest request_for(const SurfelTreeData& model, const char* name, bool orthographic,
                                 int size) {
    RenderRequest request;
    Framing framing;
    framing.orthographic = orthographic;
    request.camera = named_camera(name, model.header.bounds, 1, framing);
    request.width = request.height = size;
    request.wanted = kAllChannels;
    request.lod_px = 0;
    return request;
}

/// A sphere whose surfels were shaken: rough polynomials of full degree, mixed radii, opposed
/// sheets.
inline SurfelTreeData rough_model(int degree, std::uint64_t seed) {
    auto leaves = sphere_leaves(1, 700, 6, degree);
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        const auto noise = [&](std::uint64_t k) {
            return 2 * unit_interval(keyed_hash(seed, i, k)) - 1;
        };
        Surfel& s = leaves[i];
        s.support_radius *= 1 + 0.5 * noise(0);
        s.center += Vec3d{noise(1), noise(2), noise(3)} * (0.05 * s.support_radius);
        const int n = degree <= 1 ? 1 : n_coefficients(degree);
        for (int k = 0; k < n; ++k)
            s.polynomial.a[static_cast<std::size_t>(k)] +=
                0.15 * noise(10 + static_cast<std::uint64_t>(k));
    }
    SurfelTreeData data = flat_tree(std::move(leaves), degree);
    for (std::size_t i = 1; i < data.nodes.size(); ++i)
        data.nodes[i].level = static_cast<unsigned>(1 + i % 9) & 63u;
    return data;
}

/// The rough sphere with two or three sheets on most surfels of three, up to six on every seventh,
/// joined in every way.
inline SurfelTreeData sharp_model(int degree, std::uint64_t seed) {
    const SurfelTreeData rough = rough_model(degree, seed);
    const SurfelTree tree = rough.view();
    std::vector<Surfel> leaves;
    for (std::size_t i = 1; i < tree.n_nodes(); ++i) {
        Surfel s = tree.surfel(i);
        SharpSheets more;
        more.n_extra = i % 7 == 6 ? 3 + i % 3 : i % 3;
        more.outer = i % 2 ? Join::max : Join::min;
        more.inner = i % 4 < 2 ? Join::max : Join::min;
        for (std::size_t k = 0; k < more.n_extra; ++k) {
            const auto noise = [&](std::uint64_t n) {
                return 2 * unit_interval(keyed_hash(seed + k, i, n)) - 1;
            };
            const Vec3d tilt{noise(100), noise(101), noise(102)};
            more.extra[k] = {
                frame_from_normal(round_normal(normalized(s.frame.normal + tilt * 0.8))),
                s.polynomial};
        }
        if (more.n_extra > 0) s.sharp = std::make_shared<const SharpSheets>(more);
        leaves.push_back(s);
    }
    return flat_tree(std::move(leaves), degree);
}

}  // namespace slim::test
