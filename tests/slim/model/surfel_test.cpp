#include "slim/model/surfel.h"

#include "slim/model/surfel_encoder.h"
#include "slim/model/surfel_tree.h"
#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace slim::test {
namespace {

Polynomial<double> random_polynomial(std::uint64_t seed, int degree) {
    Polynomial<double> p;
    for (int k = 0; k < n_coefficients(degree); ++k)
        p.a[static_cast<std::size_t>(k)] = 0.3 * random_at(seed, static_cast<std::uint64_t>(k));
    return p;
}

TEST(Polynomial, IsTheSumOfItsBasis) {
    const Polynomial<double> p = random_polynomial(1, 3);
    for (std::uint64_t i = 0; i < 50; ++i) {
        const double u = random_at(2, 2 * i), v = random_at(2, 2 * i + 1);
        const double basis[] = {1,         u,         v,         u * u,     u * v,
                                v * v,     u * u * u, u * u * v, u * v * v, v * v * v};
        double sum = 0;
        for (std::size_t k = 0; k < 10; ++k) sum += p.a[k] * basis[k];
        EXPECT_NEAR(p.value(u, v), sum, 1e-15);
    }
}

TEST(Polynomial, DerivativesAreThoseOfDifferences) {
    const Polynomial<double> p = random_polynomial(3, 3);
    constexpr double h = 1e-4;
    for (std::uint64_t i = 0; i < 50; ++i) {
        const double u = random_at(4, 2 * i), v = random_at(4, 2 * i + 1);
        EXPECT_NEAR(p.d_u(u, v), (p.value(u + h, v) - p.value(u - h, v)) / (2 * h), 1e-8);
        EXPECT_NEAR(p.d_v(u, v), (p.value(u, v + h) - p.value(u, v - h)) / (2 * h), 1e-8);
        EXPECT_NEAR(p.d_uu(u, v), (p.d_u(u + h, v) - p.d_u(u - h, v)) / (2 * h), 1e-8);
        EXPECT_NEAR(p.d_uv(u, v), (p.d_u(u, v + h) - p.d_u(u, v - h)) / (2 * h), 1e-8);
        EXPECT_NEAR(p.d_vv(u, v), (p.d_v(u, v + h) - p.d_v(u, v - h)) / (2 * h), 1e-8);
    }
}

TEST(Surfel, TakesThePapersFloats) {
    EXPECT_EQ(floats_per_surfel(1), 7);
    EXPECT_EQ(floats_per_surfel(2), 12);
    EXPECT_EQ(floats_per_surfel(3), 16);
}

TEST(Surfel, LevellingKeepsThePlane) {
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        SCOPED_TRACE(seed);
        const Surfel tilted{random_in_cube(5, seed), 0.2 + 0.1 * random_at(6, seed),
                            frame_from_normal(random_direction(7, seed)),
                            random_polynomial(seed, 1), 1};
        const Surfel level = level_linear(tilted);
        EXPECT_EQ(level.polynomial.a[1], 0);
        EXPECT_EQ(level.polynomial.a[2], 0);
        EXPECT_EQ(level.center, tilted.center);
        for (std::uint64_t i = 0; i < 5; ++i) {
            const double u = random_at(8, 2 * i), v = random_at(8, 2 * i + 1);
            const Vec3d on_plane =
                tilted.frame.world_from_local({u, v, tilted.polynomial.value(u, v)});
            const Vec3d x = level.frame.local_from_world(on_plane);
            EXPECT_NEAR(x.z, level.polynomial.value(x.x, x.y), 4e-7);  // rounding of the normal
        }
    }
}

TEST(Surfel, ComesBackFromTheRecordsAsItWasEncoded) {
    for (int degree = 1; degree <= 3; ++degree) {
        SCOPED_TRACE(degree);
        std::vector<Surfel> surfels;
        for (std::uint64_t i = 0; i < 3000; ++i)  // three pages
            surfels.push_back({random_in_cube(9, i) + Vec3d{100, 0, 0}, 0.01,
                               frame_from_normal(round_normal(random_direction(10, i))),
                               random_polynomial(i, degree == 1 ? 0 : degree), degree});
        SurfelTreeData data;
        data.header.degree = degree;
        data.nodes.resize(surfels.size());
        for (TreeNode& n : data.nodes) n.degree = static_cast<unsigned>(degree) & 3u;
        encode_surfels(surfels, data);
        ASSERT_EQ(data.page_origins.size(), 3u);
        const SurfelTree tree = data.view();
        for (std::size_t i = 0; i < surfels.size(); ++i) {
            const Surfel s = tree.surfel(i);
            // A float of a coordinate up to the page's half extent of 1.
            ASSERT_NEAR(length(s.center - surfels[i].center), 0, 1.1e-7);
            ASSERT_EQ(s.support_radius, 0.01f);
            ASSERT_EQ(s.degree, degree);
            if (degree > 1) {
                ASSERT_EQ(s.frame.normal, surfels[i].frame.normal);
                ASSERT_EQ(s.frame.u_axis, surfels[i].frame.u_axis);
            }
            for (std::size_t k = 0; k < 10; ++k)
                ASSERT_NEAR(s.polynomial.a[k], surfels[i].polynomial.a[k], 2e-8);
        }
    }
}

TEST(Surfel, RecordsOfMixedDegreesTakeTheirOwnBytesAndComeBack) {
    std::vector<Surfel> surfels;
    SurfelTreeData data;
    data.header.degree = 3;
    std::size_t floats = 0;
    for (std::uint64_t i = 0; i < 3000; ++i) {
        const int degree = static_cast<int>(i % 4);
        surfels.push_back({random_in_cube(9, i), 0.01,
                           frame_from_normal(round_normal(random_direction(10, i))),
                           random_polynomial(i, degree), degree});
        data.nodes.emplace_back();
        data.nodes.back().degree = static_cast<unsigned>(degree) & 3u;
        floats += static_cast<std::size_t>(floats_per_surfel(degree));
    }
    encode_surfels(surfels, data);
    EXPECT_EQ(data.records.size(), floats);
    ASSERT_EQ(data.in_page.size(), surfels.size());
    const SurfelTree tree = data.view();
    for (std::size_t i = 0; i < surfels.size(); ++i) {
        const Surfel s = tree.surfel(i);
        ASSERT_EQ(s.degree, surfels[i].degree);
        ASSERT_NEAR(length(s.center - surfels[i].center), 0, 1.1e-7);
        // The surface at the centre, whatever the frame that a plane was turned to.
        const Vec3d on = surfels[i].frame.world_from_local({0, 0, surfels[i].polynomial.a[0]});
        const Vec3d x = s.frame.local_from_world(on);
        ASSERT_NEAR(x.z, s.polynomial.value(x.x, x.y), 4e-7) << i;
    }
    for (Surfel& s : surfels) s.degree = 3;  // equal ones need no index
    encode_surfels(surfels, data);
    EXPECT_TRUE(data.in_page.empty() && data.page_start.empty());
    EXPECT_EQ(data.records.size(), surfels.size() * 16);
}

}  // namespace
}  // namespace slim::test
