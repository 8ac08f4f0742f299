#include "formats/face_sizes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace slim::test {
namespace {

constexpr double kNoShare = std::numeric_limits<double>::infinity();

struct TestMesh {
    std::vector<Vec3d> position;
    std::vector<std::vector<std::uint32_t>> faces;

    FaceList list() const {
        FaceList out;
        out.position = position;
        for (const auto& face : faces) {
            out.corner.insert(out.corner.end(), face.begin(), face.end());
            out.end.push_back(out.corner.size());
        }
        return out;
    }
};

/// Faces 0 and 1 are below and above (x down and up first), 12 triangles in all.
TestMesh box(double a, double b, double c) {
    TestMesh out;
    for (std::uint32_t i = 0; i < 8; ++i)
        out.position.push_back({a * (i >> 2 & 1), b * (i >> 1 & 1), c * (i & 1)});
    out.faces = {{0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}, {0, 1, 3}, {0, 3, 2},
                 {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1}, {2, 3, 7}, {2, 7, 6}};
    return out;
}

/// A cylinder about z whose sides are quadrangles; the caps are the last faces.
TestMesh cylinder(std::uint32_t n, double radius, double height) {
    TestMesh out;
    std::vector<std::uint32_t> below, above;
    for (std::uint32_t k = 0; k < n; ++k) {
        const double angle = 2 * M_PI * k / n;
        out.position.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
        out.position.push_back(out.position.back() + Vec3d{0, 0, height});
        const std::uint32_t a = 2 * k, b = 2 * ((k + 1) % n);
        out.faces.push_back({a, b, b + 1, a + 1});
        above.push_back(2 * k + 1), below.push_back(2 * (n - 1 - k));
    }
    out.faces.push_back(below), out.faces.push_back(above);
    return out;
}

std::pair<double, double> sizes_about(const FaceSizes& sizes, std::size_t face) {
    double least = kNoShare, most = 0;
    for (const SizedEdge& e : sizes.edges_of(sizes.region_of(face)))
        least = std::min(least, e.size), most = std::max(most, e.size);
    return {least, most};
}

/// An angle profile along z, its ends left open: webs of 40 x 120, so thick.
TestMesh angle_profile(double thick) {
    TestMesh out;
    const double t = thick;
    const std::vector<std::pair<double, double>> outline{{0, 0}, {40, 0}, {40, t},
                                                         {t, t}, {t, 40}, {0, 40}};
    for (const auto& [x, y] : outline)
        for (const double z : {0.0, 120.0}) out.position.push_back({x, y, z});
    for (std::uint32_t k = 0; k < 6; ++k) {
        const std::uint32_t a = 2 * k, b = 2 * ((k + 1) % 6);
        out.faces.push_back({a, b, b + 1, a + 1});
    }
    return out;
}

double size_along(const FaceSizes& sizes, std::size_t face, double x, double y) {
    for (const SizedEdge& e : sizes.edges_of(sizes.region_of(face)))
        if (e.from.x == x && e.from.y == y && e.to.x == x && e.to.y == y) return e.size;
    return kNoShare;
}

TEST(FaceSizes, AnAngleProfileIsAsLargeAsItsCornerIsThick) {
    const TestMesh profile = angle_profile(1);
    const FaceList list = profile.list();
    const FaceSizes sizes(list, 1e-3, 1.0 / 12);
    // The outer edge of the corner, of the first web's outer face, and the hollow one.
    EXPECT_NEAR(size_along(sizes, 0, 0, 0), std::sqrt(2), 1e-9);
    EXPECT_NEAR(size_along(sizes, 2, 1, 1), std::sqrt(2), 1e-9);
}

TEST(FaceSizes, AnEdgeMetInItsMiddleIsNoThickness) {
    // Two walls on one floor edge that is one edge of the floor and two of the walls.
    TestMesh mesh;
    mesh.position = {{0, 0, 0}, {60, 0, 0}, {60, 50, 1e-9}, {0, 50, 0}, {25, 0, 1e-9},
                     {0, 0, 40}, {25, 0, 40}, {60, 0, 40}};
    mesh.faces = {{0, 1, 2, 3}, {0, 4, 6, 5}, {4, 1, 7, 6}};
    const FaceList list = mesh.list();
    const FaceSizes sizes(list, 1e-3, 1.0 / 12);
    for (const std::size_t face : {0, 1, 2}) EXPECT_GT(sizes_about(sizes, face).first, 5);
}

TEST(FaceSizes, APlateIsAsLargeAsItIsThick) {
    const TestMesh plate = box(100, 60, 3);
    const FaceList list = plate.list();
    const FaceSizes sizes(list, 1e9, 1.0 / 12);
    EXPECT_EQ(sizes.n_regions(), 6u);
    EXPECT_EQ(sizes.region_of(0), sizes.region_of(1));
    // Of the narrow sides 2 A / P is a little less than their width.
    const auto [least, most] = sizes_about(sizes, 0);
    EXPECT_NEAR(least, 2 * 180.0 / 126, 1e-9);
    EXPECT_NEAR(most, 2 * 300.0 / 206, 1e-9);
    EXPECT_EQ(sizes.edges_of(sizes.region_of(0)).size(), 4u);  // not the diagonal
}

TEST(FaceSizes, FacesWithVerticesOfTheirOwnAreJoinedByPlace) {
    const TestMesh plate = box(100, 60, 3);
    TestMesh apart;
    for (const auto& face : plate.faces) {
        const auto first = static_cast<std::uint32_t>(apart.position.size());
        for (const std::uint32_t v : face) apart.position.push_back(plate.position[v]);
        apart.faces.push_back({first, first + 1, first + 2});
    }
    const FaceList list = apart.list();
    const FaceSizes sizes(list, 1e9, 1.0 / 12);
    EXPECT_EQ(sizes.n_regions(), 6u);
    EXPECT_NEAR(sizes_about(sizes, 0).first, 2 * 180.0 / 126, 1e-9);
}

TEST(FaceSizes, FacetsThatTurnByMoreThanTwelveDegreesAreAsLargeAsTheyAreWide) {
    const TestMesh rod = cylinder(24, 1, 100);
    const FaceList list = rod.list();
    const FaceSizes sizes(list, 1e9, 1.0 / 12);
    EXPECT_EQ(sizes.n_regions(), 3u);
    const auto [least, most] = sizes_about(sizes, 0);
    EXPECT_NEAR(least, 2 * std::sin(M_PI / 24), 1e-9);
    EXPECT_NEAR(most, 1, 0.02);
}

TEST(FaceSizes, ARodIsAsLargeAsItsRadius) {
    const TestMesh rod = cylinder(36, 1, 100);
    const FaceList list = rod.list();
    const FaceSizes sizes(list, 1e9, 1.0 / 12);
    EXPECT_EQ(sizes.n_regions(), 3u);
    const auto [least, most] = sizes_about(sizes, 0);
    EXPECT_NEAR(least, 1, 0.02);
    EXPECT_NEAR(most, 1, 0.02);
}

TEST(FaceSizes, FacesWoundAgainstEachOtherTurnNoMore) {
    TestMesh plate = box(100, 60, 3);
    std::swap(plate.faces[1][1], plate.faces[1][2]);
    const FaceList list = plate.list();
    const FaceSizes sizes(list, 1e9, 1.0 / 12);
    EXPECT_EQ(sizes.region_of(0), sizes.region_of(1));
}

TEST(FaceSizes, NothingIsSaidOfPiecesThatTheirVerticesSample) {
    TestMesh both = cylinder(24, 1, 0.2);  // its faces are small beside 2, those of the plate not
    const std::size_t n = both.faces.size();
    const auto first = static_cast<std::uint32_t>(both.position.size());
    const TestMesh plate = box(100, 60, 3);
    for (const Vec3d& p : plate.position) both.position.push_back(p + Vec3d{10, 0, 0});
    for (auto face : plate.faces) {
        for (std::uint32_t& v : face) v += first;
        both.faces.push_back(face);
    }
    const FaceList list = both.list();
    const FaceSizes sizes(list, 2.5, kNoShare);
    for (std::size_t f = 0; f < n; ++f)
        EXPECT_TRUE(sizes.edges_of(sizes.region_of(f)).empty()) << f;
    EXPECT_FALSE(sizes.edges_of(sizes.region_of(n)).empty());
}

TEST(FaceSizes, FacesWithoutAreaOrPlaceTakeNoPart) {
    TestMesh plate = box(100, 60, 3);
    const double nan = std::nan("");
    plate.position.push_back({nan, 0, 0});
    plate.position.push_back({50, 0, 0});
    plate.faces.push_back({0, 8, 4});
    plate.faces.push_back({0, 9, 4});
    plate.faces.push_back({0, 0, 0});
    plate.faces.push_back({});
    const FaceList list = plate.list();
    const FaceSizes sizes(list, 1e9, 1.0 / 12);
    EXPECT_NEAR(sizes_about(sizes, 0).first, 2 * 180.0 / 126, 1e-9);
    for (std::size_t f = 12; f < list.size(); ++f)
        EXPECT_TRUE(sizes.edges_of(sizes.region_of(f)).empty()) << f;
}

}  // namespace
}  // namespace slim::test
