#include "formats/face_points.h"

#include "formats/ply_face_normals.h"
#include "slim/base/hash.h"
#include "tests/formats/format_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace slim::test {
namespace {

/// A unit cube of 12 triangles, wound outwards or inwards; or a plate.
std::string cube(bool outwards = true, double thickness = 1) {
    std::string text =
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty "
        "float z\n"
        "element face 12\nproperty list uchar int vertex_indices\nend_header\n";
    for (int i = 0; i < 8; ++i)
        text += std::to_string(i >> 2 & 1) + ' ' + std::to_string(i >> 1 & 1) + ' ' +
                std::to_string((i & 1) * thickness) + '\n';
    const int faces[12][3] = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},
                              {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
    for (const auto& f : faces) {
        const int b = outwards ? f[1] : f[2], c = outwards ? f[2] : f[1];
        text +=
            "3 " + std::to_string(f[0]) + ' ' + std::to_string(b) + ' ' + std::to_string(c) + '\n';
    }
    return text;
}

PointChunk with_face_points(const std::string& path) {
    const auto source = open_cloud(path, true);
    PointChunk all;
    EXPECT_TRUE(source->read(all, 1000000));
    EXPECT_EQ(source->info().n_points, all.size());
    return all;
}

/// The farthest that a point of the plate's side at x = 1 is from its nearest other one.
double largest_distance_on_side(const PointChunk& points) {
    std::vector<Vec3d> side;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (points.normal[i].x > 0.99f) side.push_back(points.position[i]);
    double most = side.size() < 2 ? 10 : 0;
    for (const Vec3d& p : side) {
        double nearest = 10;
        for (const Vec3d& q : side)
            if (p != q) nearest = std::min(nearest, length(p - q));
        most = std::max(most, nearest);
    }
    return most;
}

TEST(FacePoints, CoverTheSidesOfACube) {
    const TempFolder folder;
    const std::string path = folder.write("c.ply", cube());
    const PointChunk vertices = read_all(path), all = with_face_points(path);
    EXPECT_EQ(vertices.size(), 8u);  // unless asked for
    EXPECT_TRUE(
        std::equal(vertices.position.begin(), vertices.position.end(), all.position.begin()));
    EXPECT_TRUE(std::equal(vertices.normal.begin(), vertices.normal.end(), all.normal.begin()));
    // One for each square of a sixtieth of the diagonal, and none farther off than two of them.
    const double spacing = std::sqrt(3.0) / 60;
    EXPECT_NEAR(static_cast<double>(all.size()), 6 / (spacing * spacing),
                0.02 * static_cast<double>(all.size()));
    for (std::size_t i = 8; i < all.size(); ++i) {
        const Vec3d d = all.position[i] - Vec3d{0.5, 0.5, 0.5}, n = to_double(all.normal[i]);
        ASSERT_NEAR(dot(d, n), 0.5, 1e-12);
        ASSERT_NEAR(length(n), 1, 1e-6);
    }
    for (double x = 0.01; x < 1; x += 0.07)
        for (double y = 0.01; y < 1; y += 0.07) {
            double nearest = 1;
            for (const Vec3d& p : all.position)
                nearest = std::min(nearest, length(p - Vec3d{x, y, 0}));
            ASSERT_LT(nearest, 2 * spacing) << x << ' ' << y;
        }
    const PointChunk turned = with_face_points(folder.write("i.ply", cube(false)));
    for (std::size_t i = 8; i < turned.size(); ++i)
        ASSERT_GT(dot(turned.position[i] - Vec3d{0.5, 0.5, 0.5}, to_double(turned.normal[i])), 0.4);
}

TEST(FacePoints, AreAsDenseAsAPlateIsThin) {
    const TempFolder folder;
    const PointChunk all = with_face_points(folder.write("p.ply", cube(true, 0.03)));
    EXPECT_LT(largest_distance_on_side(all), 0.2 * 0.03);
    // Dense at the rim, at a distance of 0.3 no denser than the whole is.
    const auto above = [&](double from, double to) {
        double n = 0;
        for (std::size_t i = 8; i < all.size(); ++i) {
            const Vec3d& p = all.position[i];
            const double to_rim = std::min({p.x, p.y, 1 - p.x, 1 - p.y});
            if (all.normal[i].z > 0.99f && to_rim >= from && to_rim < to) ++n;
        }
        return n / 4 / ((to - from) * (1 - from - to));  // a unit of area
    };
    const double spacing = 0.15 * 0.03;
    EXPECT_GT(above(0, 0.02) * spacing * spacing, 0.6);
    EXPECT_LT(above(0.4, 0.5), 1.5 * 3600 / 2);  // the diagonal of a plate is sqrt(2)
    EXPECT_LT(all.size(), 60000u);
}

TEST(FacePoints, PlatesThatAreTooThinHaveABoundedNumber) {
    const TempFolder folder;
    const auto source = open_cloud(folder.write("p.ply", cube(true, 1e-4)), true);
    EXPECT_GT(source->info().n_face_points, 100000u);
    EXPECT_LT(source->info().n_face_points, 220000u);
    EXPECT_GT(source->info().face_points_from_size, 1e-4);
    EXPECT_LT(source->info().face_points_from_size, 0.05);
    const auto thick = open_cloud(folder.write("c.ply", cube()), true);
    EXPECT_EQ(thick->info().face_points_from_size, 0);
}

/// 12,500 strips of their own in a box, as grass has them.
std::string strips(std::uint64_t seed) {
    constexpr int kStrips = 12500;
    std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(4 * kStrips) +
                       "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                       std::to_string(kStrips) +
                       "\nproperty list uchar int vertex_indices\nend_header\n";
    for (std::uint64_t i = 0; i < kStrips; ++i) {
        const auto at = [&](std::uint64_t k) {
            return 0.5 * unit_interval(keyed_hash(seed, i, k));
        };
        for (const auto& [dx, dy] : {std::pair{0.0, 0.0}, {0.6, 0.0}, {0.6, 0.012}, {0.0, 0.012}})
            text += std::to_string(at(0) + dx) + ' ' + std::to_string(at(1) + dy) + ' ' +
                    std::to_string(at(2)) + '\n';
    }
    for (int i = 0; i < kStrips; ++i) {
        text += "4";
        for (int k = 0; k < 4; ++k) text += ' ' + std::to_string(4 * i + k);
        text += '\n';
    }
    return text;
}

TEST(FacePoints, TheSearchForTheirNumberEnds) {
    const TempFolder folder;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        const auto source = open_cloud(folder.write("s.ply", strips(seed)), true);
        EXPECT_LT(source->info().n_face_points, 220000u) << seed;
    }
}

TEST(FacePoints, OfASmallSolidBesideALargeOneAreAsDenseAsItAsks) {
    // Its triangles are no larger than two of the spacings that the whole asks for.
    std::vector<Vec3d> position;
    FaceList list;
    const int faces[12][3] = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},
                              {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
    for (const double size : {30.0, 1.0}) {
        const auto first = static_cast<std::uint32_t>(position.size());
        for (int i = 0; i < 8; ++i)
            position.push_back(Vec3d{size * (i >> 2 & 1), size * (i >> 1 & 1), size * (i & 1)} +
                               Vec3d{size < 2 ? 40.0 : 0.0, 0, 0});
        for (const auto& f : faces) {
            for (const int k : f) list.corner.push_back(first + static_cast<std::uint32_t>(k));
            list.end.push_back(list.corner.size());
        }
    }
    list.position = position;
    FacePoints points;
    const auto corners = [&](std::size_t f) {
        const auto c = list[f];
        return std::vector<Vec3d>{position[c[0]], position[c[1]], position[c[2]]};
    };
    for (std::size_t f = 0; f < list.size(); ++f) points.measure(corners(f));
    points.choose_spacing(60, position.size());
    ASSERT_TRUE(points.wants_sizes());
    EXPECT_GT(points.spacing(), 0.7);
    std::vector<FacePoints::Point> out;
    points.sample_sized(list, out);
    const std::size_t n = out.size();
    const auto is_of_small = [](const auto& p) { return p.position.x > 35; };
    EXPECT_GT(std::count_if(out.begin(), out.end(), is_of_small), 400);
    const std::vector<std::size_t> vertices{0, 1, 2};
    for (std::size_t f = 0; f < list.size(); ++f) points.sample(corners(f), vertices, out);
    EXPECT_EQ(out.size(), n);  // not twice
}

TEST(FacePoints, NoneWhereFacesAreAlikeOrNoFaces) {
    FacePoints faces;
    std::vector<FacePoints::Point> out;
    const std::vector<Vec3d> small{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    const std::vector<std::size_t> vertices{0, 1, 2};
    for (int i = 0; i < 100; ++i) faces.measure(small);
    faces.choose_spacing(1000, 100);
    faces.sample(small, vertices, out);
    EXPECT_TRUE(out.empty());
    const double nan = std::nan("");
    const std::vector<std::size_t> five{0, 1, 2, 3, 4};
    for (const std::vector<Vec3d>& bad :
         std::vector<std::vector<Vec3d>>{{{0, 0, 0}, {50, 0, 0}, {100, 0, 0}},
                                         {{0, 0, 0}, {50, 0, 0}, {nan, 50, 0}},
                                         {{0, 0, 0}, {50, 0, 0}}}) {
        faces.measure(bad);
        faces.sample(bad, std::span(five).first(bad.size()), out);
        EXPECT_TRUE(out.empty()) << bad.size();
    }
    faces.sample(std::vector<Vec3d>{{0, 0, 0}, {50, 0, 0}, {50, 50, 0}, {0, 50, 0}},
                 std::span(five).first(4), out);
    EXPECT_NEAR(static_cast<double>(out.size()), 2500, 100);
}

}  // namespace
}  // namespace slim::test
