#pragma once

#include "slim/model/point_block.h"
#include "tests/slim/fit/fit_support.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace slim::test {

inline PointBlock random_cube(std::size_t n, std::uint64_t seed) {
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (std::size_t i = 0; i < n; ++i) {
        positions.push_back(random_in_cube(seed, i));
        normals.push_back(to_float(random_direction(seed + 1, i)));
    }
    return block_of(std::move(positions), std::move(normals));
}

/// Clouds that a tree may stumble over: sizes about a bucket and about a node, equal points, a
/// line.
inline std::vector<PointBlock> hard_blocks() {
    std::vector<PointBlock> blocks;
    for (const std::size_t n : {1u, 2u, 15u, 16u, 17u, 64u, 65u, 257u, 3000u})
        blocks.push_back(random_cube(n, n));
    PointBlock equal = random_cube(200, 5);
    for (Vec3d& p : equal.position) p = {1, 2, 3};
    blocks.push_back(equal);
    PointBlock line = random_cube(500, 6);
    for (Vec3d& p : line.position) p = {p.x, 0, 0};
    blocks.push_back(line);
    return blocks;
}

inline std::vector<double> brute_distances(const PointBlock& block, const Vec3d& q, std::size_t k) {
    std::vector<double> all;
    for (const Vec3d& p : block.position) all.push_back(sq_length(p - q));
    std::sort(all.begin(), all.end());
    all.resize(std::min(k, all.size()));
    return all;
}

}  // namespace slim::test
