#pragma once

#include "slim/base/frame.h"
#include "slim/base/vec.h"
#include "slim/model/surfel.h"
#include "slim/model/surfel_encoder.h"
#include "slim/model/surfel_tree.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

namespace slim::test {

/// Point i of n spread evenly over the unit sphere (spherical Fibonacci lattice).
inline Vec3d fibonacci_point(std::size_t i, std::size_t n) {
    const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(n);
    const double angle = 2 * std::numbers::pi * kGoldenRatio * static_cast<double>(i);
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
}

/// Surfel on a sphere about the origin: the height field of its cap at `normal`, developed to the
/// degree (the cap has no cubic part: degree 3 differs in the kernels that it exercises).
inline Surfel sphere_surfel(const Vec3d& normal, double sphere_radius, double rho, int degree) {
    const Vec3d n = round_normal(normal);
    Surfel s{n * sphere_radius, rho, frame_from_normal(n), {}, degree};
    if (degree >= 2) s.polynomial.a[3] = s.polynomial.a[5] = -0.5 * rho / sphere_radius;
    return s;
}

/// Surfel on the torus around the z axis at tube angle b and turn a: osculating paraboloid, for
/// degree 3 with the cubic term of the change of curvature along the tube.
inline Surfel torus_surfel(double big, double small, double a, double b, double rho, int degree) {
    const Vec3d out{std::cos(a), std::sin(a), 0};
    const Vec3d n = round_normal(out * std::cos(b) + Vec3d{0, 0, std::sin(b)});
    const Vec3d around{-std::sin(a), std::cos(a), 0};  // principal direction of k_a
    const Vec3d tube = cross(n, around);
    Surfel s{out * (big + small * std::cos(b)) + Vec3d{0, 0, small * std::sin(b)}, rho,
             frame_from_normal(n), {}, degree};
    const double k_a = std::cos(b) / (big + small * std::cos(b)), k_b = 1 / small;
    const double au = dot(around, s.frame.u_axis), av = dot(around, s.frame.v_axis);
    const double bu = dot(tube, s.frame.u_axis), bv = dot(tube, s.frame.v_axis);
    s.polynomial.a[3] = -0.5 * rho * (k_a * au * au + k_b * bu * bu);
    s.polynomial.a[4] = -rho * (k_a * au * av + k_b * bu * bv);
    s.polynomial.a[5] = -0.5 * rho * (k_a * av * av + k_b * bv * bv);
    if (degree < 3) return s;
    // w = ... - c x^2 y with x along `around`, y along `tube`: c = (dk_a / dy) / 2.
    const double ring = big + small * std::cos(b);
    const double sign = dot(tube, out) * -std::sin(b) > 0 ? 1 : -1;  // tube towards growing b?
    const double c = 0.5 * rho * rho * sign * (-big * std::sin(b) / (small * ring * ring));
    s.polynomial.a[6] = -c * au * au * bu;
    s.polynomial.a[7] = -c * (au * au * bv + 2 * au * av * bu);
    s.polynomial.a[8] = -c * (av * av * bu + 2 * au * av * bv);
    s.polynomial.a[9] = -c * av * av * bv;
    return s;
}

/// A tree of one root and leaves below it; level 3, fit error 0.001 (index + 1).
inline SurfelTreeData flat_tree(std::vector<Surfel> leaves, int degree) {
    SurfelTreeData data;
    data.header.degree = degree;
    Bbox box;
    for (const Surfel& s : leaves) box.extend(s.center);
    double bound = 0;
    for (const Surfel& s : leaves)
        bound = std::max(bound, length(s.center - box.center()) + s.support_radius);
    data.header.bounds = box;
    data.header.diagonal = box.diagonal();
    data.header.n_leaves = leaves.size();
    const auto n = static_cast<std::uint32_t>(leaves.size());
    leaves.insert(leaves.begin(),
                  Surfel{box.center(), bound, frame_from_normal(Vec3d{0, 0, 1}), {}, 0});
    encode_surfels(leaves, data);
    data.nodes.push_back({1, n, static_cast<float>(bound * 1.0001)});
    for (std::uint32_t i = 0; i < n; ++i) {
        const Surfel& leaf = leaves[i + 1];
        TreeNode& node = data.nodes.emplace_back();
        node.bound_radius = static_cast<float>(leaf.support_radius);
        node.fit_error = 0.001f * static_cast<float>(i + 1);
        node.n_points = 30;
        node.level = 3;
        node.degree = static_cast<unsigned>(leaf.degree) & 3u;
        node.flags = static_cast<std::uint8_t>(leaf.sharp ? kLeaf | kSharp : kLeaf);
    }
    return data;
}

/// Leaves covering a sphere about the origin; a point lies in about `overlap` balls.
inline std::vector<Surfel> sphere_leaves(double sphere_radius, std::size_t n, double overlap,
                                         int degree) {
    const double rho = sphere_radius * std::sqrt(4 * overlap / static_cast<double>(n));
    std::vector<Surfel> leaves;
    for (std::size_t i = 0; i < n; ++i)
        leaves.push_back(sphere_surfel(fibonacci_point(i, n), sphere_radius, rho, degree));
    return leaves;
}

inline SurfelTreeData sphere_model(double sphere_radius, std::size_t n, int degree = 2,
                                   double overlap = 6) {
    return flat_tree(sphere_leaves(sphere_radius, n, overlap, degree), degree);
}

/// Fit errors of 1e-6 (index + 1).
inline SurfelTreeData torus_model(double big, double small, int n_around, int n_tube, int degree) {
    const double rho = 1.6 * std::max(2 * std::numbers::pi * (big + small) / n_around,
                                      2 * std::numbers::pi * small / n_tube);
    std::vector<Surfel> leaves;
    for (int i = 0; i < n_around; ++i)
        for (int j = 0; j < n_tube; ++j)
            leaves.push_back(torus_surfel(big, small,
                                          2 * std::numbers::pi * (i + 0.5 * (j % 2)) / n_around,
                                          2 * std::numbers::pi * j / n_tube, rho, degree));
    SurfelTreeData data = flat_tree(std::move(leaves), degree);
    for (TreeNode& node : data.nodes) node.fit_error *= 0.001f;
    return data;
}

/// A sphere with a second level: each coarse surfel stands for the leaves nearest to it.
inline SurfelTreeData two_level_sphere(double sphere_radius, std::size_t n_coarse,
                                       std::size_t n_fine) {
    const auto coarse = sphere_leaves(sphere_radius, n_coarse, 6, 2);
    const auto fine = sphere_leaves(sphere_radius, n_fine, 6, 2);
    std::vector<std::vector<Surfel>> below(n_coarse);
    for (const Surfel& s : fine) {
        std::size_t best = 0;
        for (std::size_t i = 1; i < n_coarse; ++i)
            if (sq_length(s.center - coarse[i].center) < sq_length(s.center - coarse[best].center))
                best = i;
        below[best].push_back(s);
    }
    std::vector<Surfel> all = coarse;
    SurfelTreeData data = flat_tree(coarse, 2);
    for (std::size_t i = 0; i < n_coarse; ++i) {
        TreeNode& node = data.nodes[i + 1];
        node.flags = 0;
        node.first_child = static_cast<std::uint32_t>(all.size() + 1);
        node.n_children = static_cast<std::uint32_t>(below[i].size());
        double bound = coarse[i].support_radius;
        for (const Surfel& s : below[i]) {
            bound = std::max(bound, length(s.center - coarse[i].center) + s.support_radius);
            all.push_back(s);
        }
        node.bound_radius = static_cast<float>(bound * 1.0001);
    }
    SurfelTreeData out = flat_tree(all, 2);
    for (std::size_t i = 0; i <= n_coarse; ++i) {
        const float bound = out.nodes[0].bound_radius;
        out.nodes[i] = data.nodes[i];
        if (i == 0) out.nodes[i].bound_radius = bound;
    }
    out.header.n_leaves = n_fine;
    return out;
}

}  // namespace slim::test
