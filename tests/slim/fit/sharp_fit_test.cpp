#include "slim/fit/sharp_fit.h"

#include "slim/fit/sharp_clusters.h"
#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

namespace slim::test {
namespace {

const Vec3d kCenter{3, -2, 0.5};

/// The boundary of a solid given by planes n . x = d through `joined`, a function of their values:
/// points of each plane inside the unit ball that lie on the joined surface. A tenth stands on the
/// edges (two values at once zero) and has the mean of its planes' normals, as a mesh's vertices
/// have.
struct Corner {
    std::vector<Vec3d> normals;
    std::vector<double> offsets;
    std::function<double(const std::vector<double>&)> joined;

    std::vector<double> values(const Vec3d& x) const {
        std::vector<double> f;
        for (std::size_t k = 0; k < normals.size(); ++k)
            f.push_back(dot(normals[k], x) - offsets[k]);
        return f;
    }
    /// Foot point on planes `a` and `b` (the same plane if a == b) of a point in space.
    Vec3d foot(Vec3d x, std::size_t a, std::size_t b) const {
        for (int i = 0; i < 200; ++i)
            for (const std::size_t k : {a, b}) x -= normals[k] * (dot(normals[k], x) - offsets[k]);
        return x;
    }
    PointBlock sample(std::size_t n, std::uint64_t seed, double noise = 0,
                      bool on_edges = true) const {
        std::vector<Vec3d> positions;
        std::vector<Vec3f> point_normals;
        for (std::uint64_t i = 0; positions.size() < n; ++i) {
            const std::size_t a = i % normals.size();
            const std::size_t b = on_edges && i % 10 == 0 ? (a + 1) % normals.size() : a;
            const Vec3d x = foot(random_in_cube(seed, i), a, b);
            std::vector<double> f = values(x);
            f[a] = f[b] = 0;
            if (sq_length(x) >= 1 || std::abs(joined(f)) > 1e-12) continue;
            positions.push_back(x + random_in_cube(seed + 1, i) * noise);
            point_normals.push_back(to_float(normalized(normals[a] + normals[b])));
        }
        return block_of(positions, point_normals);
    }
};

Corner edge(double angle_deg, bool convex) {
    const double half = angle_deg * std::numbers::pi / 360;
    const Vec3d a{std::sin(half), 0.0, std::cos(half)}, b{-std::sin(half), 0.0, std::cos(half)};
    return {{a, b}, {0.05, 0.02}, [convex](const std::vector<double>& f) {
                return convex ? std::max(f[0], f[1]) : std::min(f[0], f[1]);
            }};
}

std::optional<SharpFit> fit_corner(const Corner& corner, std::size_t n_sheets, double noise = 0,
                                   std::uint64_t seed = 5, int degree = 2, bool on_edges = true) {
    PointBlock block = corner.sample(500, seed, noise, on_edges);
    for (Vec3d& p : block.position) p = kCenter + p * 0.25;
    BallPoints<double> ball;
    gather_ball(tree_of(block), kCenter, 0.25, ball);
    SharpWork<double> work;
    return fit_sharp(ball, n_sheets, degree, std::max(noise * noise, 1e-16) * 0.25 * 0.25, work);
}

/// The joined function against the truth, at random places near the surface.
void expect_same_solid(const Corner& corner, const SharpFit& fit, double tolerance) {
    const Surfel s = fit.surfel(kCenter, 0.25);
    for (std::uint64_t i = 0; i < 2000; ++i) {
        const Vec3d x = random_in_cube(99, i);
        const double truth = corner.joined(corner.values(x));
        if (sq_length(x) > 0.5) continue;
        ASSERT_NEAR(s.value(x), truth, tolerance * (1 + std::abs(truth))) << i;
    }
}

TEST(SharpFit, RecoversEdgesOfAnyAngleConvexAndConcave) {
    for (const double angle : {40.0, 60.0, 90.0, 120.0, 150.0})
        for (const bool convex : {true, false}) {
            SCOPED_TRACE(testing::Message() << angle << (convex ? " convex" : " concave"));
            const Corner corner = edge(angle, convex);
            const auto fit = fit_corner(corner, 2);
            ASSERT_TRUE(fit);
            EXPECT_EQ(fit->outer, convex ? Join::max : Join::min);
            EXPECT_EQ(fit->degree, 1) << "planes need no more";
            EXPECT_EQ(fit->n_off, 0u);
            // Normals are floats: planes are found from positions alone.
            EXPECT_LT(fit->sq_error, 1e-20);
            // Slopes differ from 1 by the rounded frame only.
            expect_same_solid(corner, *fit, 2e-3);
        }
}

TEST(SharpFit, RecoversCornersOfAllFourKinds) {
    const std::vector<Vec3d> axes{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const std::vector<double> offsets{0.05, -0.03, 0.02};
    using F = std::vector<double>;
    const std::vector<std::pair<Join, Join>> joins{{Join::max, Join::max},
                                                   {Join::min, Join::min},
                                                   {Join::max, Join::min},
                                                   {Join::min, Join::max}};
    for (std::size_t odd = 0; odd < 3; ++odd)
        for (const auto& [outer, inner] : joins) {
            SCOPED_TRACE(testing::Message()
                         << "odd " << odd << " joins " << int(outer) << int(inner));
            const Corner corner{axes, offsets, [=, o = outer, i = inner](const F& f) {
                return join(o, f[odd], join(i, f[(odd + 1) % 3], f[(odd + 2) % 3]));
            }};
            const auto fit = fit_corner(corner, 3);
            ASSERT_TRUE(fit);
            EXPECT_EQ(fit->outer, outer);
            EXPECT_EQ(fit->inner, inner);
            EXPECT_EQ(fit->n_off, 0u);
            EXPECT_LT(fit->sq_error, 1e-20);
            expect_same_solid(corner, *fit, 2e-3);
        }
}

/// n faces about the z axis, `slope` steep, that meet at a point.
Corner apex(std::size_t n, double slope, bool convex) {
    Corner out;
    for (std::size_t k = 0; k < n; ++k) {
        const double a = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(n);
        out.normals.push_back(normalized(Vec3d{slope * std::cos(a), slope * std::sin(a), 1}));
        out.offsets.push_back(0.05 * out.normals.back().z);
    }
    out.joined = [convex](const std::vector<double>& f) {
        return convex ? *std::max_element(f.begin(), f.end())
                      : *std::min_element(f.begin(), f.end());
    };
    return out;
}

/// The same of points that lie on faces alone, as those that meshes of faces are given do.
std::optional<SharpFit> fit_faces(const Corner& corner, std::size_t n_sheets) {
    return fit_corner(corner, n_sheets, 0, 5, 2, false);
}

TEST(SharpFit, RecoversAnApexOfFourToSixFaces) {
    for (std::size_t n = 4; n <= kMostSheets; ++n)
        for (const bool convex : {true, false}) {
            SCOPED_TRACE(testing::Message() << n << (convex ? " convex" : " concave"));
            const Corner corner = apex(n, 1.5, convex);
            const auto fit = fit_faces(corner, n);
            ASSERT_TRUE(fit);
            EXPECT_EQ(fit->n_sheets, n);
            EXPECT_EQ(fit->outer, convex ? Join::max : Join::min);
            EXPECT_EQ(fit->inner, fit->outer);
            EXPECT_EQ(fit->n_off, 0u);
            EXPECT_LT(fit->sq_error, 1e-20);
            expect_same_solid(corner, *fit, 2e-3);
        }
}

TEST(SharpFit, RecoversFourFacesOfWhichOneIsUnlike) {
    // A ridge roof of three faces that stands on a plane: min(plane, max of the others).
    Corner corner = apex(3, 1.5, true);
    corner.normals.push_back({0, 0, 1}), corner.offsets.push_back(-0.45);
    corner.joined = [](const std::vector<double>& f) {
        return std::min(f[3], std::max({f[0], f[1], f[2]}));
    };
    const auto fit = fit_faces(corner, 4);
    ASSERT_TRUE(fit);
    EXPECT_EQ(fit->outer, Join::min);
    EXPECT_EQ(fit->inner, Join::max);
    EXPECT_EQ(fit->n_off, 0u);
    expect_same_solid(corner, *fit, 2e-3);
}

TEST(SharpFit, FlatFacesMayMeetAtTenDegreesButNoisyOnesNot) {
    const Corner corner = edge(10, true);
    const auto fit = fit_faces(corner, 2);
    ASSERT_TRUE(fit);
    EXPECT_LT(fit->sq_error, 1e-20);
    expect_same_solid(corner, *fit, 2e-3);
    PointBlock block = corner.sample(500, 5);
    for (std::size_t i = 0; i < block.normal.size(); ++i)
        block.normal[i] =
            to_float(normalized(to_double(block.normal[i]) + random_in_cube(8, i) * 0.1));
    BallPoints<double> ball;
    gather_ball(tree_of(block), {}, 1, ball);
    SharpWork<double> work;
    EXPECT_FALSE(fit_sharp(ball, 2, 2, 1e-16, work));
}

TEST(SharpFit, NoiseMovesTheSheetsByNoMoreThanItsStandardError) {
    const Corner corner = edge(90, true);
    const double noise = 0.01;
    const auto fit = fit_corner(corner, 2, noise);
    ASSERT_TRUE(fit);
    // Uniform in [-noise, noise] along the normal: variance noise^2 / 3, in units of the radius.
    EXPECT_NEAR(std::sqrt(fit->sq_error) / 0.25, noise / std::sqrt(3.0), 0.15 * noise);
    expect_same_solid(corner, *fit, 5 * noise / std::sqrt(500 / 4.0));
}

TEST(SharpFit, ACurvedFaceTakesTheFullDegree) {
    // A cylinder of radius 1.5 about the y axis, cut by the plane x = 0.05.
    std::vector<Vec3d> positions;
    std::vector<Vec3f> normals;
    for (std::uint64_t i = 0; positions.size() < 600; ++i) {
        Vec3d x = random_in_cube(7, i);
        Vec3d n{1, 0, 0};
        if (i % 2) {
            x.x = 0.05;
        } else {
            const double z = std::sqrt(1.5 * 1.5 - x.x * x.x) - 1.5;
            n = Vec3d{x.x, 0, z + 1.5} / 1.5;
            x.z = z;
        }
        const double cap = std::sqrt(1.5 * 1.5 - x.x * x.x) - 1.5;
        if (sq_length(x) >= 1 || x.x > 0.05 || x.z > cap) continue;
        positions.push_back(kCenter + x);
        normals.push_back(to_float(n));
    }
    const PointBlock block = block_of(positions, normals);
    BallPoints<double> ball;
    gather_ball(tree_of(block), kCenter, 1, ball);
    SharpWork<double> work;
    const auto flat = fit_sharp(ball, 2, 1, 1e-4, work), full = fit_sharp(ball, 2, 2, 1e-4, work);
    ASSERT_TRUE(flat);
    ASSERT_TRUE(full);
    EXPECT_EQ(full->degree, 2);
    EXPECT_EQ(full->n_off, 0u);
    EXPECT_LT(full->sq_error, 0.05 * flat->sq_error);
}

TEST(SharpFit, OneSheetAndOppositeFoldsAreNoEdge) {
    BallPoints<double> ball;
    SharpWork<double> work;
    const PointBlock plane = graph_points(500, 1, 3, [](double, double) { return 0.0; });
    gather_ball(tree_of(plane), {}, 1, ball);
    EXPECT_EQ(normal_spread(ball), 0);
    EXPECT_FALSE(shows_edge(ball));
    EXPECT_FALSE(fit_sharp(ball, 2, 2, 0, work));
    // A step: two level planes and a wall have two normals, but no two sheets.
    const Corner floor{{{0, 0, 1}, {1, 0, 0}, {0, 0, 1}}, {0.3, 0, -0.3}, [](const auto& f) {
                           return std::max(f[0], std::min(f[1], f[2]));
                       }};
    const auto step = fit_corner(floor, 2);
    EXPECT_TRUE(!step || step->n_off > 50 || step->sq_error > 0.01 * 0.25 * 0.25);
}

TEST(SharpClusters, SpreadOfNormalsIsThatOfAnEdge) {
    const PointBlock block = edge(90, true).sample(4000, 3);
    BallPoints<float> ball;
    gather_ball(tree_of(block), {0, 0, 0}, 1, ball);
    // A tenth of the points has the mean normal: 1 - (0.9 / sqrt 2 + 0.1) = 0.264 for faces of
    // equal area.
    EXPECT_NEAR(normal_spread(ball), 0.264, 0.05);
}

TEST(SharpClusters, EdgesAndCornersShowButCapsAndCylindersDoNot) {
    BallPoints<float> ball;
    for (const double angle : {40.0, 90.0, 150.0}) {
        gather_ball(tree_of(edge(angle, true).sample(600, 3)), {}, 1, ball);
        EXPECT_TRUE(shows_edge(ball)) << angle;
    }
    const Corner corner{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}, [](const auto& f) {
                            return std::max({f[0], f[1], f[2]});
                        }};
    gather_ball(tree_of(corner.sample(600, 3)), {}, 1, ball);
    EXPECT_TRUE(shows_edge(ball));
    for (const char* shape : {"sphere", "cylinder"})
        for (const double radius : {0.2, 0.3, 0.4}) {
            const Cloud cloud = sampled(shape, 4000);
            gather_ball(tree_of(block_of(cloud)), cloud.positions[0], radius, ball);
            EXPECT_FALSE(shows_edge(ball)) << shape << ' ' << radius;
        }
}

TEST(SharpClusters, FlatFacesShowAtSmallAnglesAndAboutAnApexButCurvedOnesDoNot) {
    BallPoints<float> ball;
    for (const double angle : {8.0, 20.0, 40.0}) {
        gather_ball(tree_of(edge(angle, true).sample(600, 3)), {}, 1, ball);
        EXPECT_TRUE(shows_faces(ball)) << angle;
    }
    for (const std::size_t n : {4u, 5u, 6u}) {
        gather_ball(tree_of(apex(n, 1, true).sample(900, 3, 0, false)), {}, 1, ball);
        EXPECT_TRUE(shows_faces(ball)) << n;
    }
    for (const char* shape : {"sphere", "cylinder"})
        for (const double radius : {0.1, 0.2, 0.4}) {
            const Cloud cloud = sampled(shape, 4000);
            gather_ball(tree_of(block_of(cloud)), cloud.positions[0], radius, ball);
            EXPECT_FALSE(shows_faces(ball)) << shape << ' ' << radius;
        }
}

TEST(SharpFit, ASampleInFloatsFindsTheSameSheets) {
    const PointBlock block = edge(70, false).sample(400, 11);
    BallPoints<float> coarse;
    BallPoints<double> exact;
    gather_ball(tree_of(block), {}, 1, coarse);
    gather_ball(tree_of(block), {}, 1, exact);
    SharpWork<float> coarse_work;
    SharpWork<double> exact_work;
    const auto a = fit_sharp(coarse, 2, 2, 0, coarse_work),
               b = fit_sharp(exact, 2, 2, 0, exact_work);
    ASSERT_TRUE(a && b);
    for (std::size_t k = 0; k < 2; ++k) {
        EXPECT_EQ(a->frame[k].normal, b->frame[k].normal);
        for (std::size_t i = 0; i < 3; ++i)
            EXPECT_NEAR(a->polynomial[k].a[i], b->polynomial[k].a[i], 1e-5);
    }
}

}  // namespace
}  // namespace slim::test
