#include "slim/fit/local_fit.h"

#include "tests/slim/fit/ball_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

namespace slim::test {
namespace {

/// n points on `lines` parallel lines in the plane, turned by an angle.
template <class T>
BallPoints<T> scan_lines(int lines, std::size_t n, double angle) {
    std::vector<Vec3d> positions;
    for (std::size_t i = 0; i < n; ++i) {
        const double u = 0.9 * random_at(1, i);
        const double v =
            lines == 1 ? 0
                       : 0.4 * (2.0 * static_cast<double>(i % static_cast<std::size_t>(lines)) /
                                    (lines - 1) -
                                1);
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

TEST(LocalFitFallbacks, Row08ScanLinesLowerTheDegreeWhateverTheirDirection) {
    // Degree d needs d + 1 lines (NUMERICS 2.4).
    expect_degree_by_lines<double>();
    expect_degree_by_lines<float>();
}

TEST(LocalFitFallbacks, FewPointsLowerTheDegree) {
    const auto degree_of = [](std::size_t n, int wanted, Enough enough = Enough::points) {
        const auto ball = ball_of<double>(
            n, 1, 11, [](double u, double v) { return 0.1 * u * v; }, 0.6);
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
    // The weights make a third of the points count here: K + 2 effective ones,
    // for an estimate of eps, are more.
    EXPECT_EQ(degree_of(60, 3, Enough::freedom), 3);
    EXPECT_EQ(degree_of(20, 3, Enough::freedom), 2);
    EXPECT_EQ(degree_of(24, 2, Enough::freedom), 2);
    EXPECT_EQ(degree_of(12, 2, Enough::freedom), 1);
    EXPECT_EQ(degree_of(11, 3), 1);
    EXPECT_EQ(degree_of(6, 1), 1);
    EXPECT_EQ(degree_of(2, 2), 0);
    EXPECT_EQ(degree_of(1, 3), 0);
}

TEST(LocalFitFallbacks, SteepFieldsFallBackUntilTheyStayInTheirBall) {
    const auto bowl = ball_of<double>(
        400, 1, 4, [](double u, double v) { return 4 * u * u + 0.1 * v; }, 0.48);
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

TEST(LocalFitFallbacks, ARightAngledEdgeIsAParabolaWhereverItRuns) {
    for (double angle = 0; angle < 3; angle += 0.19) {
        SCOPED_TRACE(angle);
        const auto edge = ball_of<double>(
            400, 1, 4,
            [&](double u, double v) {
                return -std::abs(u * std::cos(angle) + v * std::sin(angle));
            },
            0.7);
        const LocalFit fit = fit_ball(edge, 1, kUpright, 2);
        EXPECT_EQ(fit.degree, 2);
        EXPECT_LT(std::sqrt(fit.sq_error), 0.08);  // a plane has 0.15
    }
}

TEST(LocalFitFallbacks, CoincidingPointsMakeADisc) {
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

TEST(LocalFitFallbacks, NoPointAtAllIsThePlaneThroughTheCentre) {
    BallPoints<double> empty;
    gather_ball(PointTree(PointBlock{}, {}), kCenter, 1, empty);
    const LocalFit fit = fit_ball(empty, 1, kUpright, 3);
    EXPECT_EQ(fit.degree, 0);
    EXPECT_EQ(fit.fallback, Fallback::plane);
    EXPECT_EQ(fit.sq_error, 0);
    EXPECT_EQ(fit.n_points, 0u);
    for (const double a : fit.polynomial.a) EXPECT_EQ(a, 0);
}

TEST(LocalFitFallbacks, PointsSetAsideDoNotCount) {
    auto ball = ball_of<double>(300, 1, 8, [](double u, double v) { return 0.1 * u * v; }, 0.5);
    for (std::size_t i = 0; i < ball.n; i += 2) ball.z[i] = 0.7, ball.nz[i] = -1;
    std::vector<SetAside<double>> aside;
    set_contrary_aside(ball, {0, 0, 1}, aside);
    const LocalFit fit = fit_ball(ball, 1, kUpright, 2);
    EXPECT_NEAR(fit.polynomial.a[4], 0.1, 1e-12);
    EXPECT_EQ(fit.n_points, ball.n / 2);
    EXPECT_EQ(aside.size(), (ball.n + 1) / 2);
}

TEST(LocalFitFallbacks, APointOffTheSheetIsToldFromABadNormal) {
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

}  // namespace
}  // namespace slim::test
