#include "slim/fit/points_on_faces.h"

#include "slim/base/parallel.h"
#include "tests/slim/fit/noise_support.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

namespace slim::test {
namespace {

constexpr double kSpacing = 1.0 / 32;
constexpr double kNoise = 0.3 * kSpacing, kTilt = 0.2;

/// With noise of every coordinate and of the normals.
PointBlock in_noise(std::vector<Vec3d> positions, const std::vector<Vec3d>& normals, double noise,
                    double tilt) {
    constexpr std::uint64_t kPlaces = 1, kNormals = 2;
    std::vector<Vec3f> turned;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        Vec3d n = normals[i];
        for (std::size_t k = 0; k < 3; ++k) {
            positions[i][k] += noise * gaussian(kPlaces, 3 * i + k);
            n[k] += tilt * gaussian(kNormals, 3 * i + k);
        }
        turned.push_back(to_float(normalized(n)));
    }
    return along_curve(block_of(positions, turned));
}

/// The cube [-1, 1]^3 as a mesh has it: the vertices of an edge have the mean of its normals.
PointBlock cube(double noise, double tilt) {
    std::vector<Vec3d> positions, normals;
    constexpr int n = 32;
    for (int x = -n; x <= n; ++x)
        for (int y = -n; y <= n; ++y)
            for (int z = -n; z <= n; ++z) {
                const int at[3] = {x, y, z};
                Vec3d p, normal;
                for (std::size_t k = 0; k < 3; ++k) {
                    p[k] = double(at[k]) / n;
                    normal[k] = at[k] == n ? 1 : at[k] == -n ? -1 : 0;
                }
                if (!(sq_length(normal) > 0)) continue;
                positions.push_back(p);
                normals.push_back(normal);
            }
    return in_noise(positions, normals, noise, tilt);
}

double to_cube(const Vec3d& p) {
    return std::abs(std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) - 1);
}

struct Errors {
    double distance = 0, turn = 0;  ///< RMS; of normals, radians
};

/// Of points that are farther from the cube's edges than that and nearer than 0.5.
Errors errors_of(const PointBlock& points, const PointBlock& places, double from_edge) {
    Errors out;
    double n = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3d at = places.position[i];
        double a[3] = {std::abs(at.x), std::abs(at.y), std::abs(at.z)};
        const auto axis = static_cast<std::size_t>(std::max_element(a, a + 3) - a);
        std::sort(a, a + 3);
        if (1 - a[1] < from_edge || 1 - a[1] > 0.5) continue;
        Vec3d face;
        face[axis] = at[axis] > 0 ? 1 : -1;
        const double d = to_cube(points.position[i]);
        out.distance += d * d;
        out.turn += sq_length(to_double(points.normal[i]) - face);
        ++n;
    }
    return {std::sqrt(out.distance / n), std::sqrt(out.turn / n)};
}

TEST(PointsOnFaces, FacesOfACubeAgreeUpToItsEdges) {
    const PointBlock noisy = cube(kNoise, kTilt);
    const PointBlock out = points_on_faces(noisy, PartNoise{.spacing = kSpacing}.reach());
    ASSERT_EQ(out.size(), noisy.size());
    EXPECT_EQ(out.id, noisy.id);
    const Errors before = errors_of(noisy, noisy, 2 * kSpacing);
    const Errors after = errors_of(out, noisy, 2 * kSpacing);
    EXPECT_NEAR(before.distance, kNoise, 0.1 * kNoise);
    EXPECT_LT(after.distance, 0.3 * before.distance);
    EXPECT_LT(after.turn, 0.4 * before.turn);
    // the rows beside the edges too: they are not rounded off
    const Errors rows = errors_of(out, noisy, 0.7 * kSpacing);
    EXPECT_LT(rows.distance, 0.4 * before.distance);
    EXPECT_LT(rows.turn, 0.5 * before.turn);
}

TEST(PointsOnFaces, ACubeWithoutNoiseStays) {
    const PointBlock exact = cube(0, 0);
    const PointBlock out = points_on_faces(exact, PartNoise{.spacing = kSpacing}.reach());
    for (std::size_t i = 0; i < exact.size(); ++i) {
        EXPECT_LT(length(out.position[i] - exact.position[i]), 1e-9);
        EXPECT_LT(sq_length(to_double(out.normal[i]) - to_double(exact.normal[i])), 1e-12);
    }
}

TEST(PointsOnFaces, ACylinderIsAsWideAsBefore) {
    constexpr double radius = 0.3;  // 10 spacings
    std::vector<Vec3d> positions, normals;
    for (std::size_t i = 0; i < 4000; ++i) {
        const double turn = std::numbers::pi * random_at(5, 2 * i), h = random_at(5, 2 * i + 1);
        normals.push_back({std::cos(turn), std::sin(turn), 0});
        positions.push_back(normals.back() * radius + Vec3d{0, 0, h});
    }
    const PointBlock out =
        points_on_faces(in_noise(positions, normals, kNoise, kTilt), 3.5 * kSpacing);
    double mean = 0, square = 0, n = 0;
    for (const Vec3d& p : out.position) {
        if (std::abs(p.z) > 0.8) continue;  // beside the ends
        const double off = std::hypot(p.x, p.y) - radius;
        mean += off, square += off * off, ++n;
    }
    EXPECT_LT(std::abs(mean / n), 0.08 * kNoise);
    EXPECT_LT(std::sqrt(square / n), 0.5 * kNoise);
}

TEST(PointsOnFaces, PointsWithoutNormalsStayAndSayNothing) {
    PointBlock noisy = cube(kNoise, kTilt);
    for (std::size_t i = 0; i < noisy.size(); i += 3) {
        noisy.normal[i] = {};
        noisy.position[i] += Vec3d{0, 0, 0.02};
    }
    const PointBlock out = points_on_faces(noisy, 3.5 * kSpacing);
    for (std::size_t i = 0; i < noisy.size(); i += 3) {
        EXPECT_EQ(out.position[i], noisy.position[i]);
        EXPECT_EQ(out.normal[i], Vec3f{});
    }
    // on the faces across z, from which those without stand off
    double square = 0, n = 0;
    for (std::size_t i = 0; i < noisy.size(); ++i) {
        const Vec3d p = noisy.position[i];
        if (i % 3 == 0 || std::max(std::abs(p.x), std::abs(p.y)) > 0.9) continue;
        square += to_cube(out.position[i]) * to_cube(out.position[i]), ++n;
    }
    EXPECT_LT(std::sqrt(square / n), 0.4 * kNoise);
}

TEST(PointsOnFaces, AreTheSameForAnyNumberOfThreads) {
    const PointBlock noisy = cube(kNoise, kTilt);
    const PointBlock many = points_on_faces(noisy, 3.5 * kSpacing);
    const ThreadLimit one(1);
    const PointBlock alone = points_on_faces(noisy, 3.5 * kSpacing);
    EXPECT_EQ(many.position, alone.position);
    EXPECT_EQ(many.normal, alone.normal);
}

TEST(PointsOnFaces, ExactPartsAndTheirRoundingAreNotInNoise) {
    // lambda and the noise of a typical place of fandisk, exact and with noise, and of nefertiti
    const double spacing = 0.0942;
    EXPECT_FALSE((PartNoise{2.81e-4, 3.5e-8, spacing}).is_everywhere());
    EXPECT_TRUE((PartNoise{1.46e-3, 1.22e-3, spacing}).is_everywhere());
    EXPECT_FALSE((PartNoise{0.0432, 0.0082, 1}).is_everywhere());
    EXPECT_FALSE((PartNoise{1e-12, 1e-12, 1}).is_everywhere());
    EXPECT_FALSE((PartNoise{1, 1, 0}).is_everywhere()) << "the spacing is not known";
    const PartNoise left = PartNoise{1.46e-3, 1.22e-3, spacing}.left();
    EXPECT_NEAR(left.variance, 0.4 * 1.22e-3 + 0.24e-3, 1e-9);
    EXPECT_NEAR(left.typical_variance, 0.4 * 1.22e-3, 1e-9);
}

}  // namespace
}  // namespace slim::test
