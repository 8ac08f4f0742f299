#include "slim/smooth/mesh_distance.h"

#include "slim/base/hash.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace slim {
namespace {

Vec3d random_point(std::uint64_t seed, std::uint64_t i, double size) {
    const auto at = [&](std::uint64_t axis) {
        return unit_interval(keyed_hash(seed, i, axis)) - 0.5;
    };
    return Vec3d{at(0), at(1), at(2)} * size;
}

TEST(MeshDistance, KnowsFacesEdgesCornersAndDegenerateTriangles) {
    const Vec3d a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0};
    EXPECT_DOUBLE_EQ(sq_distance_to_triangle({0.2, 0.2, 3}, a, b, c), 9);
    EXPECT_DOUBLE_EQ(sq_distance_to_triangle({0.5, -2, 0}, a, b, c), 4);
    EXPECT_DOUBLE_EQ(sq_distance_to_triangle({2, 0, 0}, a, b, c), 1);
    EXPECT_DOUBLE_EQ(sq_distance_to_triangle({1, 1, 0}, a, b, c), 0.5);
    EXPECT_DOUBLE_EQ(sq_distance_to_triangle({0.5, 1, 0}, a, b, b), 1);
    EXPECT_DOUBLE_EQ(sq_distance_to_triangle({0, 3, 4}, a, a, a), 25);
}

TEST(MeshDistance, AgreesWithBruteForce) {
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
        Mesh mesh;
        for (std::uint64_t i = 0; i < 900; ++i)
            mesh.position.push_back(random_point(seed, i / 3, 2) + random_point(seed + 9, i, 0.2));
        for (std::size_t i = 0; i < 900; i += 3) mesh.add_face(std::array{i, i + 1, i + 2});
        const MeshDistance distance(mesh);
        for (std::uint64_t q = 0; q < 300; ++q) {
            const Vec3d p = random_point(seed + 100, q, 4);
            double best = std::numeric_limits<double>::infinity();
            for (std::size_t i = 0; i < 900; i += 3)
                best = std::min(best,
                                sq_distance_to_triangle(p, mesh.position[i], mesh.position[i + 1],
                                                        mesh.position[i + 2]));
            ASSERT_DOUBLE_EQ(distance.sq_distance(p), best) << seed << " " << q;
        }
    }
}

TEST(MeshDistance, LeavesOutFacesThatAreNotFinite) {
    Mesh mesh;
    mesh.position = {{0, 0, 0}, {1, 0, 0}, {0, std::nan(""), 0}};
    mesh.add_face(std::array<std::size_t, 3>{0, 1, 2});
    const MeshDistance distance(mesh);
    EXPECT_EQ(distance.n_triangles(), 0u);
    EXPECT_TRUE(std::isinf(distance.sq_distance({0, 0, 0})));
}

}  // namespace
}  // namespace slim
