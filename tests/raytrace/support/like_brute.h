#pragma once

#include "raytrace/brute/brute_renderer.h"
#include "slim/base/hash.h"
#include "tests/raytrace/support/analytic_models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>

namespace slim::test {

struct Difference {
    std::uint64_t covered = 0, hit = 0, depth = 0, normal = 0, curvature = 0, third = 0;
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

/// Pixels that differ: in the mask, or in position by more than 1e-5 of the winner's radius.
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
        d.depth += std::abs(dot(p - q, view.forward)) > 1e-5 * rho + rounding;
        const Vec3d n{fast.normal[0][i], fast.normal[1][i], fast.normal[2][i]};
        const Vec3d m{reference.normal[0][i], reference.normal[1][i], reference.normal[2][i]};
        d.normal += length(n - m) > 1e-3;
        d.curvature +=
            std::abs(fast.mean[i] - reference.mean[i]) > 1e-3 * (1 + std::abs(reference.mean[i]));
        d.third += third_order_differs(fast, reference, i);
    }
    return d;
}

/// A picture against that of the reference renderer.
inline void expect_like_brute(const SurfelTreeData& model, const RenderRequest& request,
                              const GBuffer& fast) {
    GBuffer reference;
    render_brute(model.view(), request, reference);
    const Difference d = difference(model, request, fast, reference);
    const auto allowed = static_cast<double>(d.covered) * 1e-4 + 1;
    EXPECT_GT(d.covered, 100u);
    EXPECT_LE(static_cast<double>(d.hit + d.depth), allowed);
    EXPECT_LE(static_cast<double>(d.normal), allowed);
    EXPECT_LE(static_cast<double>(d.curvature), allowed);
    EXPECT_LE(static_cast<double>(d.third), 3 * allowed);
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
    return flat_tree(std::move(leaves), degree);
}

/// The rough sphere with two or three sheets on two surfels of three, joined in every way.
inline SurfelTreeData sharp_model(int degree, std::uint64_t seed) {
    const SurfelTreeData rough = rough_model(degree, seed);
    const SurfelTree tree = rough.view();
    std::vector<Surfel> leaves;
    for (std::size_t i = 1; i < tree.n_nodes(); ++i) {
        Surfel s = tree.surfel(i);
        SharpSheets more;
        more.n_extra = i % 3;
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
