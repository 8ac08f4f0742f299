#pragma once

#include "slim/base/bbox.h"
#include "slim/base/hash.h"
#include "slim/model/point_block.h"
#include "slim/neighbors/point_tree.h"
#include "tests/support/shapes.h"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <vector>

namespace slim::test {

/// Uniform in [-1, 1), the n-th number of a seed.
inline double random_at(std::uint64_t seed, std::uint64_t n) {
    return 2 * unit_interval(keyed_hash(seed, n)) - 1;
}

inline Vec3d random_in_cube(std::uint64_t seed, std::uint64_t n) {
    return {random_at(seed, 3 * n), random_at(seed, 3 * n + 1), random_at(seed, 3 * n + 2)};
}

inline Vec3d random_direction(std::uint64_t seed, std::uint64_t n) {
    const double z = random_at(seed, 2 * n);
    const double angle = std::numbers::pi * random_at(seed, 2 * n + 1);
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
}

/// Standard normal, by Box and Muller.
inline double gaussian(std::uint64_t seed, std::uint64_t n) {
    const double u = 1 - unit_interval(keyed_hash(seed, 2 * n));
    const double angle = 2 * std::numbers::pi * unit_interval(keyed_hash(seed, 2 * n + 1));
    return std::sqrt(-2 * std::log(u)) * std::cos(angle);
}

/// Points with normals; ids count from 0.
inline PointBlock block_of(std::vector<Vec3d> positions, std::vector<Vec3f> normals) {
    PointBlock block;
    block.position = std::move(positions);
    block.normal = std::move(normals);
    block.id.resize(block.size());
    std::iota(block.id.begin(), block.id.end(), std::uint64_t{0});
    return block;
}

inline PointBlock block_of(const Cloud& cloud) { return block_of(cloud.positions, cloud.normals); }

/// n points (u, v, height(u, v)) over [-extent, extent]^2, normals +z.
template <class Height>
PointBlock graph_points(std::size_t n, double extent, std::uint64_t seed, Height&& height) {
    std::vector<Vec3d> positions(n);
    for (std::size_t i = 0; i < n; ++i) {
        const double u = extent * random_at(seed, 2 * i), v = extent * random_at(seed, 2 * i + 1);
        positions[i] = {u, v, height(u, v)};
    }
    return block_of(std::move(positions), std::vector<Vec3f>(n, Vec3f{0, 0, 1}));
}

/// The block's points in another order, ids travelling with them.
inline PointBlock permuted(const PointBlock& block, std::uint64_t seed) {
    std::vector<std::size_t> order(block.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (std::size_t i = order.size(); i > 1; --i)
        std::swap(order[i - 1], order[keyed_hash(seed, i) % i]);
    PointBlock out;
    for (const std::size_t i : order) {
        out.position.push_back(block.position[i]);
        out.normal.push_back(block.normal[i]);
        out.id.push_back(block.id[i]);
    }
    return out;
}

inline Bbox box_of(const PointBlock& block) {
    Bbox box;
    for (const Vec3d& p : block.position) box.extend(p);
    return box;
}

/// The block's points in Morton order, as the stage of normals has them.
inline PointBlock along_curve(PointBlock block) {
    sort_along_curve(block, box_of(block));
    return block;
}

inline PointTree tree_of(const PointBlock& block) {
    return PointTree(block, morton_order(block, box_of(block)));
}

}  // namespace slim::test
