#include "slim/smooth/face_planes.h"
#include "slim/smooth/mesh.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace slim {
namespace {

/// Two triangles over the unit square, one edge in common.
Mesh square() {
    Mesh mesh;
    mesh.position = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    mesh.add_face(std::array<std::size_t, 3>{0, 1, 2});
    mesh.add_face(std::array<std::size_t, 3>{0, 2, 3});
    return mesh;
}

FacePlane plane(const Vec3d& point, const Vec3d& normal, double area = 1) {
    return {point, normalized(normal), area, true};
}

Vec3d moved(const std::vector<FacePlane>& planes, Vec3d x) {
    std::vector<std::uint32_t> all(planes.size());
    for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
    EXPECT_TRUE(nearest_to_planes(planes, all, x));
    return x;
}

void expect_near(const Vec3d& a, const Vec3d& b, double within) {
    EXPECT_LT(length(a - b), within) << a.x << ' ' << a.y << ' ' << a.z;
}

TEST(Mesh, FacesAroundAVertexAreFoundInOrder) {
    const Mesh mesh = square();
    const VertexFaces around(mesh);
    EXPECT_EQ(around.of(0).size(), 2u);
    EXPECT_EQ(around.of(0)[0], 0u);
    EXPECT_EQ(around.of(0)[1], 1u);
    EXPECT_EQ(around.of(1).size(), 1u);
    EXPECT_EQ(around.of(3)[0], 1u);
}

TEST(Mesh, OnlyEdgesOfOneFaceAreBoundary) {
    Mesh tetrahedron;
    tetrahedron.position = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (const auto& face : {std::array<std::size_t, 3>{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}})
        tetrahedron.add_face(face);
    EXPECT_EQ(boundary_vertices(tetrahedron), (std::vector<std::uint8_t>{0, 0, 0, 0}));
    EXPECT_EQ(boundary_vertices(square()), (std::vector<std::uint8_t>{1, 1, 1, 1}));
    // Faces of one or two corners count for nothing.
    tetrahedron.add_face(std::array<std::size_t, 1>{2});
    tetrahedron.add_face(std::array<std::size_t, 2>{0, 3});
    EXPECT_EQ(boundary_vertices(tetrahedron), (std::vector<std::uint8_t>{0, 0, 0, 0}));
}

TEST(FacePlanes, AVertexOfFacesInOnePlaneGoesThereAlongTheNormalOnly) {
    const Vec3d x =
        moved({plane({5, 0, 1}, {0, 0, 1}), plane({-3, 2, 1}, {0, 0, 1}, 4)}, {0.3, 0.7, 0});
    expect_near(x, {0.3, 0.7, 1}, 0.05);  // the pull leaves 3 %
    EXPECT_EQ(x.x, 0.3);
    EXPECT_EQ(x.y, 0.7);
}

TEST(FacePlanes, AVertexOfThreeWallsGoesToTheirCorner) {
    const std::vector<FacePlane> walls = {plane({1, 0, 0}, {1, 0, 0}), plane({0, 2, 0}, {0, 1, 0}),
                                          plane({0, 0, 3}, {0, 0, -1})};
    Vec3d x{0.9, 2.1, 3.1};
    for (int i = 0; i < 20; ++i) x = moved(walls, x);
    expect_near(x, {1, 2, 3}, 1e-9);
}

TEST(FacePlanes, NearlyParallelPlanesDoNotShootTheVertexAway) {
    // They meet 100 away; noise of two degrees decides where.
    const Vec3d x =
        moved({plane({0, 0, 1}, {0.01, 0, 1}), plane({0, 0, -1}, {-0.01, 0, 1})}, {0, 0, 0});
    EXPECT_LT(length(x), 0.1);
}

TEST(FacePlanes, FacesWithoutAreaDoNotCount) {
    const std::vector<FacePlane> planes = {plane({0, 0, 5}, {0, 0, 1}, 0)};
    Vec3d x{1, 2, 3};
    EXPECT_FALSE(nearest_to_planes(planes, std::array<std::uint32_t, 1>{0}, x));
    EXPECT_EQ(x, (Vec3d{1, 2, 3}));
}

}  // namespace
}  // namespace slim
