#include "slim/normals/estimate.h"
#include "slim/normals/orient.h"

#include "slim/base/frame.h"
#include "slim/base/parallel.h"
#include "tests/slim/fit/fit_support.h"
#include "tests/slim/normals/normals_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

namespace slim::test {
namespace {

std::vector<std::uint32_t> all_of(const PointBlock& block) {
    std::vector<std::uint32_t> ids(block.size());
    std::iota(ids.begin(), ids.end(), 0u);
    return ids;
}

NeighborGraph estimate(PointBlock& block, const std::vector<std::uint32_t>& wanted, std::size_t k,
                       std::size_t& degenerate) {
    return estimate_normals(block, NearestSearch(block.position), wanted, k, degenerate);
}

/// The block with normals estimated anew, and oriented by its neighbours alone.
OrientReport estimate_and_orient(PointBlock& block, std::size_t k = 16) {
    std::size_t degenerate = 0;
    const NeighborGraph graph = estimate(block, all_of(block), k, degenerate);
    EXPECT_EQ(degenerate, 0u);
    std::vector<bool> known(block.size(), false);
    return orient_by_neighbors(block, graph, known);
}

TEST(EstimateNormals, IsWithinADegreeOnASphere) {
    const Cloud cloud = sampled("sphere", 20000);
    PointBlock block = along_curve(block_of(cloud));
    std::size_t degenerate = 7;
    estimate(block, all_of(block), 16, degenerate);
    EXPECT_EQ(degenerate, 0u);
    double sq_sum = 0;
    for (std::size_t i = 0; i < block.size(); ++i) {
        ASSERT_NEAR(length(block.normal[i]), 1, 1e-6);
        const double sine =
            length(cross(to_double(block.normal[i]), cloud.truth[block.id[i]].normal));
        sq_sum += sine * sine;
    }
    const double rms_deg = std::sqrt(sq_sum / 20000) * 180 / std::numbers::pi;
    EXPECT_LT(rms_deg, 1);
}

/// A unit square of points with noise that is so many spacings thick, along all axes.
PointBlock noisy_square(std::size_t n, double noise, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> place(0, 1);
    std::normal_distribution<double> off(0, noise / std::sqrt(static_cast<double>(n)));
    std::vector<Vec3d> points;
    for (std::size_t i = 0; i < n; ++i)
        points.push_back(
            {place(random) + off(random), place(random) + off(random), off(random)});
    return along_curve(block_of(points, std::vector<Vec3f>(n)));
}

/// Share of the normals that are within so many degrees of the z axis, on either side.
double share_upright(const PointBlock& block, double degrees) {
    const double least = std::cos(degrees * std::numbers::pi / 180);
    std::size_t upright = 0;
    for (const Vec3f& n : block.normal) upright += std::abs(n.z) > least;
    return static_cast<double>(upright) / static_cast<double>(block.size());
}

TEST(EstimateNormals, TakesMoreNeighboursWhereNoiseHidesTheirPlane) {
    for (const double noise : {1.4, 4.0}) {
        PointBlock block = noisy_square(20000, noise, 5), few = block;
        std::size_t degenerate = 0;
        const NearestSearch search(block.position);
        const auto all = all_of(block);
        estimate_normals(few, search, all, 16, degenerate);
        const NeighborGraph graph = estimate_normals(block, search, all, 16, degenerate, {},
                                                     NoiseOfPoints::thick);
        EXPECT_LT(share_upright(few, 30), 0.75) << noise;
        EXPECT_GT(share_upright(block, 30), 0.92) << noise;
        EXPECT_GT(graph.n_widened, block.size() / 4) << noise;
        EXPECT_EQ(degenerate, 0u);
    }
}

TEST(EstimateNormals, KeepsTheUsualNeighboursOfAThinSurfaceAndACorner) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> place(0, 1);
    std::vector<Vec3d> points;  // three faces of a cube
    for (int i = 0; i < 6000; ++i) {
        Vec3d p{place(random), place(random), place(random)};
        (i % 3 == 0 ? p.x : i % 3 == 1 ? p.y : p.z) = 0;
        points.push_back(p);
    }
    PointBlock block = along_curve(block_of(points, std::vector<Vec3f>(points.size()))),
               few = block;
    std::size_t degenerate = 0;
    const NearestSearch search(block.position);
    const auto all = all_of(block);
    estimate_normals(few, search, all, 16, degenerate);
    const NeighborGraph graph =
        estimate_normals(block, search, all, 16, degenerate, {}, NoiseOfPoints::thick);
    EXPECT_LT(graph.n_widened, block.size() / 50);
    std::size_t changed = 0;
    for (std::size_t i = 0; i < block.size(); ++i) changed += !(block.normal[i] == few.normal[i]);
    EXPECT_LE(changed, graph.n_widened);
}

TEST(EstimateNormals, CountsNeighboursThatSpanNoPlane) {
    std::vector<Vec3d> line;
    for (int i = 0; i < 100; ++i) line.push_back({0.01 * i, 0, 0});
    PointBlock block = along_curve(block_of(line, std::vector<Vec3f>(line.size())));
    std::size_t degenerate = 0;
    estimate(block, all_of(block), 8, degenerate);
    EXPECT_EQ(degenerate, 100u);
    for (const Vec3f& n : block.normal) {
        EXPECT_NEAR(length(n), 1, 1e-6);
        EXPECT_NEAR(n.x, 0, 1e-3);  // any direction, but across the line
    }
}

TEST(EstimateNormals, DuplicatesGiveTheNormalsOfTheUniqueSet) {
    const Cloud cloud = sampled("torus", 3000);
    Cloud copies;
    for (int c = 0; c < 12; ++c)
        copies.positions.insert(copies.positions.end(), cloud.positions.begin(),
                                cloud.positions.end());
    PointBlock once = along_curve(block_of(cloud));
    PointBlock twelve =
        along_curve(block_of(copies.positions, std::vector<Vec3f>(copies.positions.size())));
    std::size_t degenerate = 0;
    estimate(once, all_of(once), 16, degenerate);
    estimate(twelve, all_of(twelve), 16, degenerate);
    std::vector<Vec3f> normals(cloud.size());
    for (std::size_t i = 0; i < once.size(); ++i) normals[once.id[i]] = once.normal[i];
    for (std::size_t i = 0; i < twelve.size(); ++i)
        ASSERT_GT(std::abs(dot(twelve.normal[i], normals[twelve.id[i] % cloud.size()])), 0.99999f);
}

TEST(EstimateNormals, TouchesTheWantedOnly) {
    PointBlock block = along_curve(block_of(sampled("sphere", 2000)));
    const std::vector<Vec3f> before = block.normal;
    const std::vector<std::uint32_t> wanted{3, 500, 1999};
    block.normal[3] = block.normal[500] = block.normal[1999] = {};
    std::size_t degenerate = 0;
    EXPECT_EQ(estimate(block, wanted, 16, degenerate).points, wanted);
    for (std::size_t i = 0; i < block.size(); ++i) {
        const bool is_wanted = i == 3 || i == 500 || i == 1999;
        if (is_wanted) {
            EXPECT_GT(std::abs(dot(block.normal[i], before[i])), 0.99f);
        } else {
            ASSERT_EQ(block.normal[i], before[i]);
        }
    }
}

TEST(NeighborGraph, IsCutToTheCloud) {
    PointBlock block = along_curve(block_of(sampled("sphere", 5)));
    std::size_t degenerate = 0;
    EXPECT_EQ(estimate(block, all_of(block), 16, degenerate).k, 5u);
}

TEST(Orient, ClosedShapesFaceOutwards) {
    for (const char* shape : {"sphere", "torus", "ellipsoid", "bumpy"}) {
        SCOPED_TRACE(shape);
        PointBlock block = along_curve(block_of(sampled(shape, 20000)));
        const std::vector<Vec3f> truth = block.normal;
        const OrientReport report = estimate_and_orient(block);
        EXPECT_EQ(share_agreeing(block, truth), 1);
        EXPECT_EQ(report.components, 1u);
        EXPECT_EQ(report.by_rule, block.size());
    }
}

/// A box of 1 by 1 by `height`, points at random by area.
PointBlock box_points(std::size_t n, double height) {
    PointBlock block;
    const double sides = 4 * height;
    for (std::size_t i = 0; i < n; ++i) {
        const auto unit = [&](std::uint64_t k) { return unit_interval(keyed_hash(k, i)); };
        const double u = unit(1), v = unit(2), which = unit(3) * (2 + sides);
        Vec3d p{u, v, which < 1 ? 0 : height}, n_out{0, 0, which < 1 ? -1.0 : 1.0};
        if (which > 2) {
            const int side = std::min(3, static_cast<int>((which - 2) / height));
            const double at = side % 2;
            p = side < 2 ? Vec3d{at, u, v * height} : Vec3d{u, at, v * height};
            n_out = side < 2 ? Vec3d{2 * at - 1, 0, 0} : Vec3d{0, 2 * at - 1, 0};
        }
        block.position.push_back(p);
        block.normal.push_back(to_float(n_out));
        block.id.push_back(i);
    }
    return block;
}

// A plate four spacings thick, of 16 neighbours: a spanning tree that joins the nearest to parallel
// first goes over the rim by a pair that says the wrong thing, and half of the plate faces inwards.
TEST(Orient, ManyVotesCarryTheSignRoundAThinRim) {
    for (const double height : {0.06, 0.1, 1.0}) {
        SCOPED_TRACE(height);
        PointBlock block = along_curve(box_points(4000, height));
        const std::vector<Vec3f> truth = block.normal;
        estimate_and_orient(block);
        EXPECT_GT(share_agreeing(block, truth), 0.99);
    }
}

TEST(Orient, ATerrainFacesUp) {
    PointBlock block = along_curve(graph_points(10000, 1, 5, [](double u, double v) {
        return 0.1 * std::sin(4 * u) * std::cos(3 * v);
    }));
    estimate_and_orient(block);
    for (const Vec3f& n : block.normal) ASSERT_GT(n.z, 0);
}

TEST(Orient, SeparateShapesEachFaceOutwards) {
    PointBlock block = along_curve(block_of(sampled("sphere", 5000)));
    const PointBlock other = block_of(sampled("sphere", 5000, 2));
    for (std::size_t i = 0; i < other.size(); ++i) {
        block.position.push_back(other.position[i] + Vec3d{10, 0, 0});
        block.normal.push_back(other.normal[i]);
        block.id.push_back(block.id.size());
    }
    block = along_curve(block);
    const std::vector<Vec3f> truth = block.normal;
    const OrientReport report = estimate_and_orient(block);
    EXPECT_EQ(report.components, 2u);
    EXPECT_EQ(share_agreeing(block, truth), 1);
}

TEST(Orient, KnownSignsSpreadOverTheirComponent) {
    PointBlock block = along_curve(block_of(sampled("torus", 10000)));
    const std::vector<Vec3f> truth = block.normal;
    std::size_t degenerate = 0;
    const NeighborGraph graph = estimate(block, all_of(block), 16, degenerate);
    std::vector<bool> known(block.size(), false);
    for (std::size_t i = 0; i < 3; ++i) known[i] = true, block.normal[i] = -truth[i];
    const OrientReport report = orient_by_neighbors(block, graph, known);
    EXPECT_EQ(share_agreeing(block, truth), 0);  // all inwards, as the three say
    EXPECT_EQ(report.by_neighbors, block.size() - 3);
    EXPECT_EQ(report.by_rule, 0u);
    EXPECT_EQ(report.components, 0u);
}

TEST(Orient, TowardsTheSensorOfTheScan) {
    PointBlock block = along_curve(block_of(sampled("sphere", 4000)));
    const std::vector<Vec3f> truth = block.normal;
    // Two scanners, one within the sphere: its points shall face inwards. A third scan has no
    // sensor.
    for (std::size_t i = 0; i < block.size(); ++i) {
        block.scan.push_back(i % 5 == 0 ? 2 : block.position[i].x > 0 ? 0 : 1);
        if (i % 2) block.normal[i] = -block.normal[i];
    }
    const std::vector<Vec3f> mixed = block.normal;
    const std::vector<Vec3d> sensors{{100, 0, 0}, {0, 0, 0}};
    EXPECT_EQ(orient_to_sensors(block, all_of(block), sensors), 3200u);
    for (std::size_t i = 0; i < block.size(); ++i) {
        if (block.scan[i] == 2) {
            ASSERT_EQ(block.normal[i], mixed[i]);
            continue;
        }
        const Vec3d view = sensors[block.scan[i]] - block.position[i];
        ASSERT_GE(dot(to_double(block.normal[i]), view), 0);
    }
    const std::vector<Vec3d> unknown{{NAN, NAN, NAN}};
    EXPECT_EQ(orient_to_sensors(block, all_of(block), unknown), 0u);
}

TEST(Orient, GivesTheSameForAnyNumberOfThreads) {
    std::vector<std::vector<Vec3f>> normals;
    for (const int n : {1, 2, 7}) {
        const ThreadLimit limit(n);
        PointBlock block = along_curve(block_of(sampled("sculpture", 10000, 1, 1e-3)));
        estimate_and_orient(block);
        normals.push_back(block.normal);
    }
    EXPECT_EQ(normals[0], normals[1]);
    EXPECT_EQ(normals[0], normals[2]);
}

}  // namespace
}  // namespace slim::test
