#include "slim/fit/local_fit.h"

#include "slim/fit/mdl_energy.h"
#include "slim/model/weight_kernel.h"
#include "tests/slim/fit/fit_support.h"

#include <Eigen/QR>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace slim::test {
namespace {

const Frame<double> kUpright = frame_from_normal(Vec3d{0, 0, 1});
const Vec3d kCenter{3, -2, 0.5};

Polynomial<double> random_field(std::uint64_t seed, int degree) {
    Polynomial<double> p;
    for (int k = 0; k < n_coefficients(degree); ++k)
        p.a[static_cast<std::size_t>(k)] = 0.15 * random_at(seed, static_cast<std::uint64_t>(k));
    return p;
}

/// The ball about `center` filled by points center + radius (u, v, height(u, v)), |u|, |v| <= extent.
template <class T, class Height>
BallPoints<T> ball_of(std::size_t n, double radius, std::uint64_t seed, Height&& height,
                      double extent = 1) {
    PointBlock block = graph_points(n, extent, seed, height);
    for (Vec3d& p : block.position) p = kCenter + p * radius;
    BallPoints<T> ball;
    gather_ball(tree_of(block), kCenter, radius, ball);
    return ball;
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
                    for (int t = 0; t <= d; ++t, ++k) scaled.a[k] = truth.a[k] * std::pow(shrink, d - 1);
                // Coordinates about a centre of size 3 carry 4e-16 / radius; NUMERICS section 6, 18.
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
    for (const std::size_t n : {300u, 40u, 20u, 9u})  // the last are too few for cubics, for quadratics
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
                // 60 points in the shrunken ball leave cubics short of effective points in some seeds.
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
    // What follows noise must not look better than what does not: that is what the correction is for.
    // 1 - K / n_eff corrects too much under G (the terms of higher order live where G is small): measured
    // 1.09, 1.26 and 1.76 at 79 points. The bound holds it there.
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
    const auto ball = ball_of<double>(500, 1, 3, [](double u, double v) { return 0.3 * u - 0.2 * v; });
    EXPECT_LT(std::sqrt(fit_ball(ball, 1, kUpright, 2).sq_error), 1e-14);
    const auto single = ball_of<float>(500, 1, 3, [](double u, double v) { return 0.3 * u - 0.2 * v; });
    EXPECT_LT(std::sqrt(fit_ball(single, 1, kUpright, 2).sq_error), 1e-6);
}

/// n points on `lines` parallel lines in the plane, turned by an angle.
template <class T>
BallPoints<T> scan_lines(int lines, std::size_t n, double angle) {
    std::vector<Vec3d> positions;
    for (std::size_t i = 0; i < n; ++i) {
        const double u = 0.9 * random_at(1, i);
        const double v = lines == 1 ? 0 : 0.4 * (2.0 * static_cast<double>(i % static_cast<std::size_t>(lines)) / (lines - 1) - 1);
        positions.push_back(kCenter + Vec3d{std::cos(angle) * u - std::sin(angle) * v,
                                            std::sin(angle) * u + std::cos(angle) * v,
                                            0.01 * gaussian(2, i)});
    }
    const PointBlock block = block_of(positions, std::vector<Vec3f>(n, Vec3f{0, 0, 1}));
    BallPoints<T> ball;
    gather_ball(tree_of(block), kCenter, 1, ball);
    return ball;
}

template <class T>
void expect_degree_by_lines() {
    for (int lines = 1; lines <= 4; ++lines)
        for (const double angle : {0.0, 0.3, 1.0}) {
            SCOPED_TRACE(testing::Message() << lines << " lines at " << angle);
            const LocalFit fit = fit_ball(scan_lines<T>(lines, 400, angle), 1, kUpright, 3);
            EXPECT_EQ(fit.degree, lines - 1);
            EXPECT_EQ(fit.fallback, lines == 4   ? Fallback::none
                                    : lines == 1 ? Fallback::plane
                                                 : Fallback::rank);
            EXPECT_TRUE(std::isfinite(fit.sq_error));
            EXPECT_NEAR(std::sqrt(fit.sq_error), 0.01, 0.002);
        }
}

TEST(LocalFit, Row08ScanLinesLowerTheDegreeWhateverTheirDirection) {
    // Degree d needs d + 1 lines (NUMERICS 2.4).
    expect_degree_by_lines<double>();
    expect_degree_by_lines<float>();
}

TEST(LocalFit, FewPointsLowerTheDegree) {
    const auto degree_of = [](std::size_t n, int wanted, Enough enough = Enough::points) {
        const auto ball = ball_of<double>(n, 1, 11, [](double u, double v) { return 0.1 * u * v; }, 0.6);
        EXPECT_EQ(ball.n, n);
        const LocalFit fit = fit_ball(ball, 1, kUpright, wanted, enough);
        EXPECT_TRUE(std::isfinite(fit.sq_error));
        EXPECT_EQ(fit.fallback == Fallback::none, fit.degree == wanted);
        return fit.degree;
    };
    // 2 K points.
    EXPECT_EQ(degree_of(20, 3), 3);
    EXPECT_EQ(degree_of(19, 3), 2);
    EXPECT_EQ(degree_of(12, 2), 2);
    EXPECT_EQ(degree_of(11, 2), 1);
    // The weights make a third of the points count here: K + 2 effective ones, for an estimate of eps, are more.
    EXPECT_EQ(degree_of(60, 3, Enough::freedom), 3);
    EXPECT_EQ(degree_of(20, 3, Enough::freedom), 2);
    EXPECT_EQ(degree_of(24, 2, Enough::freedom), 2);
    EXPECT_EQ(degree_of(12, 2, Enough::freedom), 1);
    EXPECT_EQ(degree_of(11, 3), 1);
    EXPECT_EQ(degree_of(6, 1), 1);
    EXPECT_EQ(degree_of(2, 2), 0);
    EXPECT_EQ(degree_of(1, 3), 0);
}

TEST(LocalFit, SteepFieldsFallBackUntilTheyStayInTheirBall) {
    const auto bowl = ball_of<double>(400, 1, 4, [](double u, double v) { return 4 * u * u + 0.1 * v; }, 0.48);
    const LocalFit linear = fit_ball(bowl, 1, kUpright, 2);
    EXPECT_EQ(linear.degree, 1);
    EXPECT_EQ(linear.fallback, Fallback::steep);
    EXPECT_NEAR(linear.polynomial.a[2], 0.1, 0.1);
    const auto wall = ball_of<double>(400, 1, 4, [](double u, double) { return 5 * u; }, 0.19);
    const LocalFit plane = fit_ball(wall, 1, kUpright, 2);
    EXPECT_EQ(plane.degree, 0);
    EXPECT_EQ(plane.fallback, Fallback::plane);
    for (std::size_t k = 1; k < kMaxCoefficients; ++k) EXPECT_EQ(plane.polynomial.a[k], 0);
}

TEST(LocalFit, ARightAngledEdgeIsAParabolaWhereverItRuns) {
    for (double angle = 0; angle < 3; angle += 0.19) {
        SCOPED_TRACE(angle);
        const auto edge = ball_of<double>(
            400, 1, 4, [&](double u, double v) { return -std::abs(u * std::cos(angle) + v * std::sin(angle)); },
            0.7);
        const LocalFit fit = fit_ball(edge, 1, kUpright, 2);
        EXPECT_EQ(fit.degree, 2);
        EXPECT_LT(std::sqrt(fit.sq_error), 0.08);  // a plane has 0.15
    }
}

TEST(LocalFit, CoincidingPointsMakeADisc) {
    for (const double off : {0.0, 0.3})
        for (int degree = 1; degree <= 3; ++degree) {
            const auto ball = ball_of<double>(50, 1, 1, [&](double, double) { return off; }, 0.0);
            ASSERT_EQ(ball.n, 50u);
            const LocalFit fit = fit_ball(ball, 1, kUpright, degree);
            EXPECT_EQ(fit.degree, 0);
            EXPECT_EQ(fit.fallback, Fallback::plane);
            EXPECT_NEAR(fit.polynomial.a[0], off, 1e-14);
            EXPECT_NEAR(fit.sq_error, 0, 1e-14);
            EXPECT_NEAR(fit.n_effective, 50, 1e-9);
        }
}

TEST(LocalFit, NoPointAtAllIsThePlaneThroughTheCentre) {
    BallPoints<double> empty;
    gather_ball(PointTree(PointBlock{}, {}), kCenter, 1, empty);
    const LocalFit fit = fit_ball(empty, 1, kUpright, 3);
    EXPECT_EQ(fit.degree, 0);
    EXPECT_EQ(fit.fallback, Fallback::plane);
    EXPECT_EQ(fit.sq_error, 0);
    EXPECT_EQ(fit.n_points, 0u);
    for (const double a : fit.polynomial.a) EXPECT_EQ(a, 0);
}

TEST(LocalFit, PointsSetAsideDoNotCount) {
    auto ball = ball_of<double>(300, 1, 8, [](double u, double v) { return 0.1 * u * v; }, 0.5);
    for (std::size_t i = 0; i < ball.n; i += 2) ball.z[i] = 0.7, ball.nz[i] = -1;
    std::vector<SetAside<double>> aside;
    set_contrary_aside(ball, {0, 0, 1}, aside);
    const LocalFit fit = fit_ball(ball, 1, kUpright, 2);
    EXPECT_NEAR(fit.polynomial.a[4], 0.1, 1e-12);
    EXPECT_EQ(fit.n_points, ball.n / 2);
    EXPECT_EQ(aside.size(), (ball.n + 1) / 2);
}

TEST(LocalFit, APointOffTheSheetIsToldFromABadNormal) {
    auto ball = ball_of<double>(300, 1, 8, [](double u, double v) { return 0.1 * u * v; }, 0.5);
    for (std::size_t i = 0; i < 20; ++i) ball.nz[i] = -1;   // in place, the normal is wrong
    for (std::size_t i = 0; i < 7; ++i) ball.z[i] += 0.3;   // and these lie on another sheet
    std::vector<SetAside<double>> aside;
    set_contrary_aside(ball, {0, 0, 1}, aside);
    const LocalFit fit = fit_ball(ball, 1, kUpright, 2);
    const std::span<const SetAside<double>> all = aside;
    EXPECT_EQ(aside.size(), 20u);
    EXPECT_EQ(count_off_sheet(ball, all, kUpright, fit, 0.2), 7u);
    EXPECT_EQ(count_off_sheet(ball, all, kUpright, fit, 0.4), 0u);
}

TEST(AverageNormal, TakesTheSideOfTheCentre) {
    auto ball = ball_of<float>(400, 1, 9, [](double, double) { return 0.0; });
    for (std::size_t i = 0; i < ball.n; i += 3) ball.nz[i] = -1;
    EXPECT_NEAR(average_normal(ball, 1, {0, 0, 1}).normal.z, 1, 1e-12);
    EXPECT_NEAR(average_normal(ball, 1, {0.5, 0, -1}).normal.z, -1, 1e-12);
    EXPECT_FALSE(average_normal(ball, 1, {0, 0, 1}).disagree);
    std::vector<SetAside<float>> aside;
    auto down = ball, unmeasured = ball;
    set_contrary_aside(ball, {0, 0, 1}, aside);
    EXPECT_EQ(aside.size(), (ball.n + 2) / 3);
    set_contrary_aside(down, {0, 0, -1}, aside);
    EXPECT_EQ(aside.size(), ball.n - (ball.n + 2) / 3);
    for (std::size_t i = 0; i < ball.n; ++i) unmeasured.nz[i] = 0;
    set_contrary_aside(unmeasured, {0, 0, 1}, aside);
    EXPECT_TRUE(aside.empty());
}

TEST(AverageNormal, FallsBackOnTheLeastSpreadWhereNormalsDisagree) {
    auto ball = ball_of<double>(400, 1, 10, [](double u, double) { return 0.2 * u; });
    for (std::size_t i = 0; i < ball.n; ++i) {
        // In all directions of the plane, with a little to the side of the centre's.
        const double angle = 2.399963 * static_cast<double>(i);
        ball.nx[i] = static_cast<float>(std::cos(angle));
        ball.ny[i] = static_cast<float>(std::sin(angle));
        ball.nz[i] = 0.05f;
    }
    const BallNormal n = average_normal(ball, 1, {0, 0, 1});
    EXPECT_TRUE(n.disagree);
    EXPECT_NEAR(length(n.normal - normalized(Vec3d{-0.2, 0, 1})), 0, 1e-6);
    const BallNormal below = average_normal(ball, 1, normalized(Vec3d{0, 0, -1}));
    EXPECT_TRUE(below.disagree);
    EXPECT_LT(below.normal.z, 0);
}

TEST(AverageNormal, OfAnEmptyBallIsTheCentresOwn) {
    BallPoints<float> empty;
    const BallNormal n = average_normal(empty, 1, {0, 1, 0});
    EXPECT_EQ(n.normal, (Vec3d{0, 1, 0}));
    EXPECT_TRUE(n.disagree);
}

TEST(LocalFit, NoiseAloneMissesNothing) {
    // Sums over 400 balls of noise: what the next degree takes off, less its share, has the mean 0 and
    // the standard error that the fit states.
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
        const auto ball = ball_of<float>(
            2000, 0.5, 3, [&](double u, double v) { return 0.05 * std::pow(u - v / 2, degree + 1); });
        const LocalFit fit = fit_ball_ahead(ball, 1, kUpright, degree);
        EXPECT_NEAR(fit.sq_missed / fit.sq_error, 1, 0.05);
    }
}

TEST(MdlEnergy, SeesTheWholeOfNoiseThatTheBallCutsOff) {
    // Balls from 20 down to 6 times the noise: the weight along the normal hides 4 to 31 % of the variance.
    constexpr double noise = 1;
    for (const double rho : {20., 10., 6.}) {
        SCOPED_TRACE(rho);
        double sum = 0;
        constexpr int runs = 20;
        for (std::uint64_t seed = 0; seed < runs; ++seed) {
            std::uint64_t i = 0;
            const auto ball = ball_of<double>(4000, rho, seed, [&](double, double) {
                return noise / rho * gaussian(seed + 500, i++);
            }, 1.0);
            sum += whole_variance(fit_ball(ball, 1, kUpright, 1).sq_error, rho) / runs;
        }
        EXPECT_NEAR(sum, noise * noise, 0.05);
    }
    // As thick as wide: no surface at all; the cap, not a division by zero.
    EXPECT_DOUBLE_EQ(whole_variance(1. / 16, 1), 20. / 16);
    EXPECT_DOUBLE_EQ(whole_variance(1, 1), 20);
}

TEST(MdlEnergy, IsThePapersAndScalesAsALengthSquared) {
    const MdlEnergy energy{1e-6, 0.02};
    const double whole = 3e-5 / (1 - 16 * 3e-3);
    EXPECT_DOUBLE_EQ(energy(3e-5, 0.1), whole + 1e-6 * 0.04);
    constexpr double s = 1024;
    const MdlEnergy scaled{1e-6 * s * s, 0.02 * s};
    EXPECT_DOUBLE_EQ(scaled(3e-5 * s * s, 0.1 * s), s * s * energy(3e-5, 0.1));
    LocalFit fit;
    fit.degree = 2, fit.sq_error = 3e-5, fit.n_effective = 56;
    EXPECT_DOUBLE_EQ(energy.upper_bound(fit, 0.1), energy(3e-5, 0.1) + 2 * whole * std::sqrt(2.0 / 50));
    fit.n_effective = 1;
    EXPECT_TRUE(std::isfinite(energy.upper_bound(fit, 0.1)));
}

}  // namespace
}  // namespace slim::test
