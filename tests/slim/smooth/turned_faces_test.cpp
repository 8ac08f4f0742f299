#include "slim/smooth/turned_faces.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <vector>

namespace slim {
namespace {

/// n x n vertices of a plane, two triangles a square, facing +z.
Mesh plane_mesh(std::size_t n) {
    Mesh mesh;
    for (std::size_t y = 0; y < n; ++y)
        for (std::size_t x = 0; x < n; ++x)
            mesh.position.push_back({static_cast<double>(x), static_cast<double>(y), 0});
    for (std::size_t y = 0; y + 1 < n; ++y)
        for (std::size_t x = 0; x + 1 < n; ++x) {
            const std::size_t a = y * n + x;
            mesh.add_face(std::array<std::size_t, 3>{a, a + 1, a + n + 1});
            mesh.add_face(std::array<std::size_t, 3>{a, a + n + 1, a + n});
        }
    return mesh;
}

std::size_t n_downwards(const Mesh& mesh, const std::vector<Vec3d>& at) {
    std::size_t n = 0;
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        const auto c = mesh.face(f);
        n += cross(at[c[1]] - at[c[0]], at[c[2]] - at[c[0]]).z < 0 ? 1 : 0;
    }
    return n;
}

TurnedFaces hold_back(const Mesh& mesh, const std::vector<Vec3f>& toward,
                      const std::vector<Vec3d>& from, std::vector<Vec3d>& to) {
    return hold_back_turned(mesh, VertexFaces(mesh), toward, from, to);
}

TEST(TurnedFaces, AVertexThatWouldTurnFacesGoesAShareOfItsWay) {
    const Mesh mesh = plane_mesh(9);
    std::vector<Vec3d> to = mesh.position;
    for (Vec3d& p : to) p.z += 0.1;  // others go all theirs
    const std::size_t middle = 4 * 9 + 4;
    to[middle].x += 1.5;  // over its neighbour
    ASSERT_GT(n_downwards(mesh, to), 0u);
    const std::vector<Vec3d> wanted = to;
    const TurnedFaces found =
        hold_back(mesh, std::vector<Vec3f>(mesh.n_faces()), mesh.position, to);
    EXPECT_GT(found.turned, 0u);
    EXPECT_EQ(n_downwards(mesh, to), 0u);
    EXPECT_GT(to[middle].x, 4.1);
    std::size_t n_held_back = 0;
    for (std::size_t v = 0; v < to.size(); ++v) n_held_back += to[v] != wanted[v] ? 1u : 0u;
    EXPECT_EQ(n_held_back, found.n_held_back);
    EXPECT_LE(n_held_back, 7u);  // the corners of faces about it
    EXPECT_TRUE(found.kept.empty());
}

TEST(TurnedFaces, AVertexWhoseLeastShareWouldTurnFacesIsKept) {
    const Mesh mesh = plane_mesh(9);
    std::vector<Vec3d> to = mesh.position;
    const std::uint32_t middle = 4 * 9 + 4;
    to[middle].x += 20;  // an eighth of it is past its neighbour
    const TurnedFaces found =
        hold_back(mesh, std::vector<Vec3f>(mesh.n_faces()), mesh.position, to);
    EXPECT_EQ(found.n_held_back, 1u);
    EXPECT_EQ(found.kept, std::vector<std::uint32_t>{middle});
    EXPECT_EQ(to, mesh.position);
}

TEST(TurnedFaces, WhatTurnsTheRightWayGoes) {
    const Mesh mesh = plane_mesh(9);
    std::vector<Vec3d> from = mesh.position, to = mesh.position;
    from[40].x += 1.5;  // folded before, by noise
    ASSERT_GT(n_downwards(mesh, from), 0u);
    const std::vector<Vec3f> up(mesh.n_faces(), Vec3f{0, 0, 1});
    const TurnedFaces found = hold_back(mesh, up, from, to);
    EXPECT_EQ(found.turned, 0u);
    EXPECT_EQ(found.n_held_back, 0u);
    EXPECT_EQ(to, mesh.position);
}

TEST(TurnedFaces, NoneIsLeftWhereAllVerticesAreShaken) {
    const Mesh mesh = plane_mesh(40);
    std::vector<Vec3d> to = mesh.position;
    for (std::size_t v = 0; v < to.size(); ++v)
        to[v] += Vec3d{static_cast<double>(v * 7919 % 97) / 97 - 0.5,
                       static_cast<double>(v * 104729 % 89) / 89 - 0.5, 0} *
                 2.5;
    ASSERT_GT(n_downwards(mesh, to), 300u);
    const TurnedFaces found =
        hold_back(mesh, std::vector<Vec3f>(mesh.n_faces(), Vec3f{0, 0, 1}), mesh.position, to);
    EXPECT_GT(found.n_held_back, 300u);
    EXPECT_EQ(n_downwards(mesh, to), 0u);
}

}  // namespace
}  // namespace slim
