#include "slim/scanner/scan.h"

#include "slim/base/parallel.h"
#include "slim/scanner/range_grid.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <set>
#include <string>

namespace slim {
namespace {

ScanSettings settings_for(std::uint64_t n) {
    ScanSettings s;
    s.n_points = n;
    s.n_stations = 6;
    return s;
}

bool same_bytes(const test::Cloud& a, const test::Cloud& b) {
    const auto equal = [](const auto& x, const auto& y) {
        return x.size() == y.size() &&
               std::memcmp(x.data(), y.data(), x.size() * sizeof(x[0])) == 0;
    };
    return equal(a.positions, b.positions) && equal(a.normals, b.normals) &&
           equal(a.truth, b.truth) && equal(a.scan_ids, b.scan_ids);
}

class ScanOf : public testing::TestWithParam<std::string> {};

TEST_P(ScanOf, HitsTheSurfaceAndDeliversTheCount) {
    const Shape& shape = find_shape(GetParam());
    const test::Cloud cloud = test::scanned(GetParam(), settings_for(5'003));
    ASSERT_EQ(cloud.size(), 5'003u);
    ASSERT_EQ(cloud.normals.size(), cloud.size());
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        const Jet2 f = shape.jet(cloud.positions[i]);
        ASSERT_LT(std::abs(f.value), 1e-10 * std::max(0.1, length(f.gradient())));
        ASSERT_NEAR(sq_length(to_double(cloud.normals[i])), 1, 1e-6);
    }
}

INSTANTIATE_TEST_SUITE_P(Shapes, ScanOf, testing::ValuesIn(shape_names()),
                         [](const auto& tested) { return tested.param; });

TEST(Scan, IsTheSameForAnyNumberOfThreads) {
    ScanSettings s = settings_for(20'000);
    s.noise = 1e-3;
    s.outliers = 0.01;
    s.dropout = 0.5;
    std::array<test::Cloud, 3> clouds;
    for (std::size_t i = 0; i < 3; ++i) {
        const ThreadLimit limit(std::array{1, 2, 7}[i]);
        clouds[i] = test::scanned("sculpture", s);
    }
    EXPECT_TRUE(same_bytes(clouds[0], clouds[1]));
    EXPECT_TRUE(same_bytes(clouds[0], clouds[2]));
    s.seed = 2;
    EXPECT_FALSE(same_bytes(clouds[0], test::scanned("sculpture", s)));
}

TEST(Scan, DeliversTheExactCountAtAnySize) {
    for (const std::uint64_t n : {1u, 2u, 10u, 999u, 1000u, 33'333u}) {
        ScanSettings s = settings_for(n);
        s.dropout = 0.8;
        ScanSummary summary;
        EXPECT_EQ(test::scanned("torus", s, &summary).size(), n);
        EXPECT_EQ(summary.points, n);
    }
}

TEST(Scan, SeesEveryPartFromEveryStation) {
    ScanSummary summary;
    const test::Cloud cloud = test::scanned("sphere", settings_for(30'000), &summary);
    ASSERT_EQ(summary.sensors.size(), 6u);
    std::array<std::size_t, 6> per_station{};
    Bbox box;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        ++per_station.at(cloud.scan_ids[i]);
        box.extend(cloud.positions[i]);
        // Each hit faces the scanner that saw it.
        const Vec3d back = summary.sensors[cloud.scan_ids[i]] - cloud.positions[i];
        ASSERT_GT(dot(back, cloud.truth[i].normal), -1e-9);
    }
    for (const std::size_t n : per_station) EXPECT_NEAR(static_cast<double>(n), 5'000, 100);
    EXPECT_GT(box.diagonal(), 0.99 * std::sqrt(12.0));
}

TEST(Scan, NoiseAlongTheRayHasTheGivenDeviation) {
    ScanSettings s = settings_for(40'000);
    s.noise = 1e-3;
    ScanSummary summary;
    const test::Cloud cloud = test::scanned("sphere", s, &summary);
    const double sigma = 1e-3 * std::sqrt(12.0);
    EXPECT_NEAR(summary.sigma, sigma, 1e-15);
    double sum = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        // The exact hit is the end of the sphere's normal; the error lies along the ray.
        const Vec3d error = cloud.positions[i] - cloud.truth[i].normal;
        const Vec3d view = normalized(cloud.truth[i].normal - summary.sensors[cloud.scan_ids[i]]);
        ASSERT_NEAR(length(cross(error, view)), 0, 1e-12);
        sum += sq_length(error);
    }
    EXPECT_NEAR(std::sqrt(sum / 40'000), sigma, 0.02 * sigma);  // 1 / sqrt(2 n) is 0.0035
}

TEST(Scan, IsotropicNoiseHasItPerCoordinateAndTheTruthOfTheFootPoint) {
    ScanSettings s = settings_for(40'000);
    s.noise = 1e-3;
    s.noise_model = NoiseModel::isotropic;
    const test::Cloud cloud = test::scanned("sphere", s);
    double sum = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        ASSERT_NEAR(length(normalized(cloud.positions[i]) - cloud.truth[i].normal), 0, 1e-9);
        const double off = length(cloud.positions[i]) - 1;
        sum += off * off;
    }
    EXPECT_NEAR(std::sqrt(sum / 40'000), 1e-3 * std::sqrt(12.0), 0.02e-3 * std::sqrt(12.0));
}

TEST(Scan, OutliersHaveTheirShare) {
    ScanSettings s = settings_for(20'000);
    s.outliers = 0.05;
    ScanSummary summary;
    const test::Cloud cloud = test::scanned("sphere", s, &summary);
    const auto off = std::count_if(cloud.positions.begin(), cloud.positions.end(),
                                   [](const Vec3d& p) { return std::abs(length(p) - 1) > 1e-9; });
    EXPECT_EQ(static_cast<std::uint64_t>(off), summary.outliers);
    EXPECT_NEAR(static_cast<double>(off), 1'000, 100);  // 3 standard deviations: 92
}

TEST(Scan, DropoutThinsGrazingReturnsOnly) {
    ScanSettings s = settings_for(60'000);
    const auto grazing = [&](const test::Cloud& cloud, const ScanSummary& summary) {
        std::size_t n = 0;
        for (std::size_t i = 0; i < cloud.size(); ++i) {
            const Vec3d back = normalized(summary.sensors[cloud.scan_ids[i]] - cloud.positions[i]);
            n += dot(back, cloud.truth[i].normal) < 0.2;
        }
        return static_cast<double>(n);
    };
    ScanSummary a, b;
    const double all = grazing(test::scanned("sphere", s, &a), a);
    s.dropout = 1;
    const double thinned = grazing(test::scanned("sphere", s, &b), b);
    // cos is spread as 2 cos d(cos) over the disc that a scanner sees (nearly): the share below 0.2
    // is 0.04 without loss and 0.0165 / 0.833 with it.
    EXPECT_NEAR(all / 60'000, 0.04, 0.01);
    EXPECT_NEAR(thinned / all, 0.0108 / 0.833 / 0.04, 0.15);
    EXPECT_GT(b.rays, a.rays);
}

TEST(Scan, NormalsOfACleanScanAreNearTheTruth) {
    ScanSummary summary;
    const test::Cloud cloud = test::scanned("torus", settings_for(60'000), &summary);
    std::size_t good = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        const Vec3d n = to_double(cloud.normals[i]);
        good += dot(n, cloud.truth[i].normal) > 0.995;  // 5.7 degrees
        ASSERT_GE(dot(n, summary.sensors[cloud.scan_ids[i]] - cloud.positions[i]), -1e-5);
    }
    EXPECT_GT(static_cast<double>(good), 0.97 * 60'000);
}

TEST(Scan, AnOpenShapeShowsItsFrontOnly) {
    const test::Cloud cloud = test::scanned("plane", settings_for(4'000));
    std::size_t upright = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        ASSERT_LE(std::max(std::abs(cloud.positions[i].x), std::abs(cloud.positions[i].y)),
                  1 + 1e-12);
        ASSERT_GT(cloud.normals[i].z, 0);  // the front faces the scanner
        upright += cloud.normals[i].z > 0.9999f;
    }
    // all but corners and grazing rows, where the view direction stands in
    EXPECT_GT(upright, 3'900u);
    const std::set<std::uint16_t> seen(cloud.scan_ids.begin(), cloud.scan_ids.end());
    EXPECT_LT(seen.size(), 6u);
}

TEST(Uniform, SpreadsPointsByArea) {
    // Torus: the share of the area with rho > 1 is 1/2 + 0.35 / pi.
    const test::Cloud cloud = test::sampled("torus", 50'000, 5);
    ASSERT_EQ(cloud.size(), 50'000u);
    const auto outer = std::count_if(cloud.positions.begin(), cloud.positions.end(),
                                     [](const Vec3d& p) { return std::hypot(p.x, p.y) > 1; });
    EXPECT_NEAR(static_cast<double>(outer) / 50'000, 0.5 + 0.35 / std::numbers::pi, 0.01);
    for (std::size_t i = 0; i < cloud.size(); ++i)
        ASSERT_LT(length(to_double(cloud.normals[i]) - cloud.truth[i].normal), 1e-6);
}

TEST(Uniform, CountsBothSidesOfTheEllipsoidAlike) {
    // The mean of each coordinate vanishes; octants hold an eighth each.
    std::array<double, 8> octants{};
    for (const Vec3d& p : test::sampled("ellipsoid", 40'000, 9).positions)
        ++octants[(p.x > 0 ? 1u : 0u) + (p.y > 0 ? 2u : 0u) + (p.z > 0 ? 4u : 0u)];
    for (const double n : octants) EXPECT_NEAR(n, 5'000, 350);
}

TEST(Uniform, IsTheSameForAnyNumberOfThreads) {
    std::array<test::Cloud, 3> clouds;
    for (std::size_t i = 0; i < 3; ++i) {
        const ThreadLimit limit(std::array{1, 2, 7}[i]);
        clouds[i] = test::sampled("bumpy", 10'000, 3, 1e-3);
    }
    EXPECT_TRUE(same_bytes(clouds[0], clouds[1]));
    EXPECT_TRUE(same_bytes(clouds[0], clouds[2]));
}

}  // namespace
}  // namespace slim
