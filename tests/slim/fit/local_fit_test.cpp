#include "slim/fit/local_fit.h"

#include "slim/fit/mdl_energy.h"
#include "slim/model/weight_kernel.h"
#include "tests/slim/fit/ball_support.h"

#include <Eigen/QR>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace slim::test {
namespace {

Polynomial<double> random_field(std::uint64_t seed, int degree) {
    Polynomial<double> p;
    for (int k = 0; k < n_coefficients(degree); ++k)
        p.a[static_cast<std::size_t>(k)] = 0.15 * random_at(seed, static_cast<std::uint64_t>(k));
    return p;
}

/// The same problem by Householder QR on the weighted design matrix.
Eigen::VectorXd fit_by_qr(const BallPoints<double>& ball, double shrink, int degree) {
    const auto n = static_cast<Eigen::Index>(ball.n);
    Eigen::MatrixXd design(n, n_coefficients(degree));
    Eigen::VectorXd heights(n);
    for (Eigen::Index i = 0; i < n; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const double u = ball.x[k] / shrink, v = ball.y[k] / shrink, w = ball.z[k] / shrink;
        const double root = std::sqrt(fit_weight(ball.weight, ball.sq[k] / (shrink * shrink)));
        Eigen::Index column = 0;
        for (int d = 0; d <= degree; ++d)
            for (int t = 0; t <= d; ++t)
                design(i, column++) = root * std::pow(u, d - t) * std::pow(v, t);
        heights[i] = root * w;
    }
    return design.householderQr().solve(heights);
}

void expect_coefficients(const LocalFit& fit, const Polynomial<double>& truth, double tolerance) {
    for (std::size_t k = 0; k < kMaxCoefficients; ++k)
        EXPECT_NEAR(fit.polynomial.a[k], truth.a[k], tolerance) << "coefficient " << k;
}

TEST(LocalFit, Row18RecoversANoiselessHeightFieldOfItsDegree) {
    for (int degree = 1; degree <= 3; ++degree)
        for (std::uint64_t seed = 0; seed < 20; ++seed) {
            SCOPED_TRACE(testing::Message() << "degree " << degree << " seed " << seed);
            const Polynomial<double> truth = random_field(seed, degree);
            const double radius = std::pow(2.0, static_cast<double>(seed) - 10);
            const auto ball = ball_of<double>(300, radius, seed, [&](double u, double v) {
                return truth.value(u, v);
            });
            for (const double shrink : {1.0, 0.7}) {
                const LocalFit fit = fit_ball(ball, shrink, kUpright, degree);
                ASSERT_EQ(fit.degree, degree);
                ASSERT_EQ(fit.fallback, Fallback::none);
                Polynomial<double> scaled;  // in coordinates divided by the fit's own radius
                std::size_t k = 0;
                for (int d = 0; d <= 3; ++d)
                    for (int t = 0; t <= d; ++t, ++k)
                        scaled.a[k] = truth.a[k] * std::pow(shrink, d - 1);
                // Coordinates about a centre of size 3 carry 4e-16 / radius; NUMERICS section 6,
                // 18.
                const double rounding = 1e-12 + 2e-15 / radius;
                expect_coefficients(fit, scaled, rounding);
                EXPECT_LT(std::sqrt(fit.sq_error), rounding * radius);
            }
        }
}

TEST(LocalFit, TakesTheWeightOfItsBall) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        SCOPED_TRACE(seed);
        std::uint64_t i = 0;
        auto ball = ball_of<double>(200, 0.01, seed, [&](double u, double) {
            return 0.2 * u + 0.05 * gaussian(seed, i++);
        });
        const LocalFit gauss = fit_ball(ball, 0.9, kUpright, 2);
        ball.weight = FitWeight::polynomial;
        const LocalFit fit = fit_ball(ball, 0.9, kUpright, 2);
        const Eigen::VectorXd reference = fit_by_qr(ball, 0.9, 2);
        for (Eigen::Index k = 0; k < reference.size(); ++k)
            ASSERT_NEAR(fit.polynomial.a[static_cast<std::size_t>(k)], reference[k], 1e-12);
        EXPECT_GT(fit.n_effective, gauss.n_effective);  // a wider weight
    }
}

TEST(LocalFit, EveryDegreeAtOnceIsEachDegreeAlone) {
    // the last are too few for cubics, for quadratics
    for (const std::size_t n : {300u, 40u, 20u, 9u})
        for (std::uint64_t seed = 0; seed < 20; ++seed) {
            SCOPED_TRACE(testing::Message() << n << " points, seed " << seed);
            std::uint64_t i = 0;
            const auto ball = ball_of<double>(n, 0.01, seed, [&](double u, double v) {
                return 0.2 * u + 0.3 * u * v * v + 0.02 * gaussian(seed, i++);
            });
            const auto fits = fit_every_degree(ball, 0.9, kUpright);
            for (int degree = 1; degree <= 3; ++degree) {
                const LocalFit& fit = fits[static_cast<std::size_t>(degree - 1)];
                const LocalFit alone = fit_ball(ball, 0.9, kUpright, degree);
                ASSERT_EQ(fit.degree, alone.degree);
                ASSERT_EQ(fit.fallback, alone.fallback);
                ASSERT_EQ(fit.n_points, alone.n_points);
                ASSERT_NEAR(fit.sq_error, alone.sq_error, 1e-9 * alone.sq_error);
                expect_coefficients(fit, alone.polynomial, 1e-9);
            }
        }
}

TEST(LocalFit, AgreesWithQrOnNoisyPoints) {
    for (int degree = 1; degree <= 3; ++degree)
        for (std::uint64_t seed = 0; seed < 20; ++seed) {
            SCOPED_TRACE(testing::Message() << "degree " << degree << " seed " << seed);
            std::uint64_t i = 0;
            const auto ball = ball_of<double>(200, 0.01, seed, [&](double u, double) {
                return 0.2 * u + 0.05 * gaussian(seed, i++);
            });
            for (const double shrink : {1.0, 0.6}) {
                const LocalFit fit = fit_ball(ball, shrink, kUpright, degree);
                // 60 points in the shrunken ball leave cubics short of effective points in some
                // seeds.
                EXPECT_TRUE(fit.degree == degree || shrink < 1);
                const Eigen::VectorXd reference = fit_by_qr(ball, shrink, fit.degree);
                for (Eigen::Index k = 0; k < reference.size(); ++k)
                    EXPECT_NEAR(fit.polynomial.a[static_cast<std::size_t>(k)], reference[k], 1e-12);
            }
        }
}

TEST(LocalFit, CountsEffectiveAndInnerPoints) {
    const auto ball = ball_of<double>(400, 1, 5, [](double, double) { return 0.0; });
    for (const double shrink : {1.0, 0.5}) {
        double sum = 0, squares = 0;
        std::size_t n = 0;
        for (std::size_t i = 0; i < ball.n; ++i) {
            const double g = weight_kernel(ball.sq[i] / (shrink * shrink));
            sum += g, squares += g * g;
            n += ball.sq[i] < shrink * shrink;
        }
        const LocalFit fit = fit_ball(ball, shrink, kUpright, 2);
        EXPECT_NEAR(fit.n_effective, sum * sum / squares, 1e-9);
        EXPECT_EQ(fit.n_points, n);
    }
}

/// Mean of eps^2 / sigma^2 over balls of about 0.79 n points with noise of deviation sigma.
double mean_error_ratio(int degree, std::size_t n, int runs) {
    constexpr double sigma = 0.02, radius = 0.3;
    double sum = 0;
    for (std::uint64_t seed = 0; seed < static_cast<std::uint64_t>(runs); ++seed) {
        std::uint64_t i = 0;
        const auto ball = ball_of<double>(n, radius, seed, [&](double u, double v) {
            return 0.1 * u - 0.1 * v + sigma * gaussian(seed + 1000, i++);
        });
        const LocalFit fit = fit_ball(ball, 1, kUpright, degree);
        EXPECT_TRUE(fit.degree == degree || (n < 400 && degree == 3));
        sum += fit.sq_error / (sigma * sigma * radius * radius);
    }
    return sum / runs;
}

TEST(LocalFit, ErrorIsTheNoiseWhereThereAreManyPoints) {
    // 1570 points, n_eff = 390; 60 runs leave 1 %. Coefficients take what is divided out again.
    for (int degree = 1; degree <= 3; ++degree)
        EXPECT_NEAR(mean_error_ratio(degree, 2000, 60), 1, 0.03 + 0.02 * (degree - 1)) << degree;
}

TEST(LocalFit, ErrorOfFewPointsIsNeverBelowTheNoise) {
    // What follows noise must not look better than what does not: that is what the correction is
    // for. 1 - K / n_eff corrects too much under G (the terms of higher order live where G is
    // small): measured 1.09, 1.26 and 1.76 at 79 points. The bound holds it there.
    constexpr double most[] = {1.15, 1.35, 1.95};
    for (int degree = 1; degree <= 3; ++degree) {
        SCOPED_TRACE(degree);
        const double ratio = mean_error_ratio(degree, 100, 600);
        EXPECT_GT(ratio, 1);
        EXPECT_LT(ratio, most[degree - 1]);
    }
}

TEST(LocalFit, FloatWorkspaceAgreesWithDouble) {
    for (int degree = 1; degree <= 3; ++degree)
        for (std::uint64_t seed = 0; seed < 10; ++seed) {
            SCOPED_TRACE(testing::Message() << "degree " << degree << " seed " << seed);
            std::uint64_t i = 0;
            const auto field = [&](double u, double v) {
                return 0.1 * u * u - 0.2 * u * v * v + 0.01 * gaussian(seed, i++);
            };
            const auto fine = ball_of<double>(500, 0.1, seed, field);
            i = 0;
            const auto coarse = ball_of<float>(500, 0.1, seed, field);
            ASSERT_EQ(fine.n, coarse.n);
            const LocalFit a = fit_ball(fine, 0.8, kUpright, degree);
            const LocalFit b = fit_ball(coarse, 0.8, kUpright, degree);
            for (std::size_t k = 0; k < kMaxCoefficients; ++k)
                EXPECT_NEAR(a.polynomial.a[k], b.polynomial.a[k], 1e-5);
            EXPECT_NEAR(b.sq_error / a.sq_error, 1, 1e-3);
            EXPECT_NEAR(b.n_effective / a.n_effective, 1, 1e-5);
        }
}

TEST(LocalFit, ExactPlaneKeepsAnErrorOfRounding) {
    // The difference of sums would leave 1e-8 of the heights; the pass over the residuals does not.
    const auto ball =
        ball_of<double>(500, 1, 3, [](double u, double v) { return 0.3 * u - 0.2 * v; });
    EXPECT_LT(std::sqrt(fit_ball(ball, 1, kUpright, 2).sq_error), 1e-14);
    const auto single =
        ball_of<float>(500, 1, 3, [](double u, double v) { return 0.3 * u - 0.2 * v; });
    EXPECT_LT(std::sqrt(fit_ball(single, 1, kUpright, 2).sq_error), 1e-6);
}

TEST(LocalFit, NoiseAloneMissesNothing) {
    // Sums over 400 balls of noise: what the next degree takes off, less its share, has the mean 0
    // and the standard error that the fit states.
    constexpr double noise = 1e-3, rho = 0.5;
    for (const int degree : {1, 2, 3}) {
        SCOPED_TRACE(degree);
        double sum = 0, squares = 0, stated = 0;
        constexpr int runs = 400;
        for (std::uint64_t seed = 0; seed < runs; ++seed) {
            std::uint64_t i = 0;
            const auto ball = ball_of<float>(
                600, rho, seed, [&](double, double) { return noise * gaussian(seed + 500, i++); });
            const LocalFit fit = fit_ball_ahead(ball, 1, kUpright, degree);
            const LocalFit plain = fit_ball(ball, 1, kUpright, degree);
            EXPECT_NEAR(fit.sq_error / plain.sq_error, 1, 1e-6);
            const double unit = noise * noise * rho * rho;
            sum += fit.sq_missed / unit;
            squares += fit.sq_missed * fit.sq_missed / (unit * unit);
            stated += fit.sq_missed_error * fit.sq_missed_error / (unit * unit);
        }
        EXPECT_LT(std::abs(sum / runs), 3 * std::sqrt(squares) / runs);
        EXPECT_NEAR(std::sqrt(squares / stated), 1, 0.25);  // measured 1.1, 1.17, 1.1
    }
}

TEST(LocalFit, WhatTheNextDegreeWouldFindIsFound) {
    // Heights of one degree more than the fit's, without noise: all of eps^2 is missed.
    for (const int degree : {1, 2, 3}) {
        SCOPED_TRACE(degree);
        const auto ball = ball_of<float>(2000, 0.5, 3, [&](double u, double v) {
            return 0.05 * std::pow(u - v / 2, degree + 1);
        });
        const LocalFit fit = fit_ball_ahead(ball, 1, kUpright, degree);
        EXPECT_NEAR(fit.sq_missed / fit.sq_error, 1, 0.05);
    }
}

}  // namespace
}  // namespace slim::test
