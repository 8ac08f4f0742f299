#include "slim/fit/steady_curvature.h"

#include "slim/model/weight_kernel.h"
#include "tests/slim/fit/fit_support.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slim::test {
namespace {

const Frame<double> kUpright = frame_from_normal(Vec3d{0, 0, 1});
constexpr double kRadius = 0.1;

/// What the narrow ball about the origin gives, before and after.
struct Result {
    LocalFit plain, steady;
};

Result at_origin(const PointBlock& block, int degree, double noise_variance, int narrow_degree) {
    const PointPyramid points(block, box_of(block), 0);
    BallPoints<double> ball;
    BallPoints<float> work;
    gather_ball(points.all(), {0, 0, 0}, kRadius, ball);
    Result out;
    out.plain = fit_ball(ball, 1, kUpright, narrow_degree);
    out.steady = steady_curvature(points, {{0, 0, 0}, kUpright, ball, out.plain}, degree,
                                  noise_variance, work);
    return out;
}

/// H in 1 / length; w = P(u, v) on the outside of a convex surface has negative second derivatives.
double mean_curvature(const LocalFit& fit) {
    return -(fit.polynomial.a[3] + fit.polynomial.a[5]) / kRadius;
}

TEST(SteadyCurvature, LeavesExactDataAsTheyAre) {
    for (const int degree : {2, 3}) {
        SCOPED_TRACE(degree);
        const PointBlock block = graph_points(20000, 1, 5, [&](double u, double v) {
            return 0.4 * u * u - 0.3 * u * v + 0.2 * v * v + (degree == 3 ? 0.5 * u * u * u : 0);
        });
        const Result r = at_origin(block, degree, 1e-20, degree);
        EXPECT_EQ(r.steady.degree, degree);
        for (std::size_t k = 0; k < kMaxCoefficients; ++k)
            EXPECT_NEAR(r.steady.polynomial.a[k], r.plain.polynomial.a[k], 1e-9);
    }
}

TEST(SteadyCurvature, NoiseNoLongerSpeckles) {
    // A weakly curved cylinder (H = 0.125) with noise of 0.02 in balls of radius 0.1: the error of
    // a fit to one ball is some tens.
    double plain = 0, steady = 0;
    constexpr int kSeeds = 40;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
        PointBlock block = graph_points(
            4000, 1, seed, [](double u, double) { return std::sqrt(1 - 0.25 * u * u); });
        for (std::size_t i = 0; i < block.size(); ++i)
            block.position[i].z += 0.02 * gaussian(seed + 1000, i) - 1;
        const Result r = at_origin(block, 2, 0.02 * 0.02, 2);
        plain += std::pow(mean_curvature(r.plain) - 0.125, 2);
        steady += std::pow(mean_curvature(r.steady) - 0.125, 2);
    }
    // Two rungs of g each widen the ball 2.6 times: the error falls as rho^-3, by up to 18, and
    // what passes the test of two standard errors is rare.
    EXPECT_LT(std::sqrt(steady / kSeeds), 0.25 * std::sqrt(plain / kSeeds));
}

TEST(SteadyCurvature, KeepsABumpThatStandsOutOfTheNoise) {
    // A Gaussian bump of the ball's size: H = 10 at its top,
    // noise of 1e-4 gives an error of some tenths.
    PointBlock block = graph_points(40000, 1, 3, [](double u, double v) {
        return 0.025 * std::exp(-(u * u + v * v) / (2 * 0.05 * 0.05));
    });
    for (std::size_t i = 0; i < block.size(); ++i)
        block.position[i].z += 1e-4 * gaussian(9, i) - 0.025;
    const Result r = at_origin(block, 2, 1e-8, 2);
    EXPECT_GT(mean_curvature(r.plain), 3);
    EXPECT_NEAR(mean_curvature(r.steady), mean_curvature(r.plain), 0.05 * mean_curvature(r.plain));
}

TEST(SteadyCurvature, LendsAPlaneTheCurvatureOfItsSurroundings) {
    // A forced leaf takes a plane; its curvature comes from the wider balls:
    // 2 * 0.2 of z = -0.2 (u^2 + v^2).
    const PointBlock block = graph_points(
        4000, 1, 7, [](double u, double v) { return -0.2 * (u * u + v * v); });
    const Result r = at_origin(block, 2, 1e-12, 1);
    EXPECT_EQ(r.plain.degree, 1);
    EXPECT_EQ(r.steady.degree, 2);
    EXPECT_NEAR(mean_curvature(r.steady), 0.4, 1e-6);
    EXPECT_LT(r.steady.sq_error, r.plain.sq_error);
}

/// eps^2 as LocalFit defines it, by a pass over the residuals of a plane and terms that were given.
double sq_error_by_residuals(const BallPoints<double>& ball, const Polynomial<double>& p) {
    double rss = 0, weight = 0, sq_weight = 0;
    for (std::size_t i = 0; i < ball.n; ++i) {
        const Vec3d x = kUpright.local_from_world(Vec3d{ball.x[i], ball.y[i], ball.z[i]});
        const double g = weight_kernel(ball.sq[i]);
        rss += g * std::pow(x.z - p.value(x.x, x.y), 2);
        weight += g;
        sq_weight += g * g;
    }
    return ball.radius * ball.radius * rss / weight / (1 - 3 * sq_weight / (weight * weight));
}

TEST(SteadyCurvature, TheErrorIsThatOfTheLentCurvature) {
    // A cap, a saddle and a twist: the products of the lent terms have either sign.
    const double shapes[][3] = {{0.5, 0, 0.4}, {0.5, 0, -0.4}, {0.3, 0.6, 0.2}};
    for (const auto& a : shapes) {
        SCOPED_TRACE(a[2]);
        PointBlock block = graph_points(20000, 1, 11, [&](double u, double v) {
            return a[0] * u * u + a[1] * u * v + a[2] * v * v;
        });
        for (std::size_t i = 0; i < block.size(); ++i)
            block.position[i].z += 1e-4 * gaussian(17, i);
        const Result r = at_origin(block, 2, 1e-8, 1);
        ASSERT_EQ(r.steady.degree, 2);
        BallPoints<double> ball;
        gather_ball(PointPyramid(block, box_of(block), 0).all(), {0, 0, 0}, kRadius, ball);
        const double expected = sq_error_by_residuals(ball, r.steady.polynomial);
        EXPECT_NEAR(r.steady.sq_error, expected, 1e-6 * expected);
        EXPECT_NEAR(std::sqrt(r.steady.sq_error), 1e-4, 2e-5);
    }
}

TEST(SteadyCurvature, WithoutAWiderBallTheFitStays) {
    // Nothing beyond the narrow ball, and too few points in it for a quadric.
    const PointBlock block =
        graph_points(6, 0.05, 7, [](double u, double v) { return 0.1 * u * v; });
    const Result r = at_origin(block, 2, 1e-12, 1);
    EXPECT_EQ(r.steady.degree, r.plain.degree);
    EXPECT_EQ(r.steady.polynomial.a, r.plain.polynomial.a);
}

}  // namespace
}  // namespace slim::test
