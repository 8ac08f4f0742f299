#include "slim/smooth/nested_disc.h"

#include "slim/base/hash.h"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

namespace slim {
namespace {

constexpr std::size_t kPoints = 400;

std::vector<double> basis(double u, double v, int degree) {
    std::vector<double> phi;
    for (int d = 0; d <= degree; ++d)
        for (int b = 0; b <= d; ++b) phi.push_back(std::pow(u, d - b) * std::pow(v, b));
    return phi;
}

double height(double u, double v, std::uint64_t i) {
    return 0.3 + u - 0.2 * u * v + 0.4 * v * v * v * v + 0.01 * unit_interval(keyed_hash(2, i));
}

/// Rows of quartics at points of the unit disc, their heights, and the sums of both.
struct Sample {
    Eigen::MatrixXd rows = Eigen::MatrixXd(kPoints, 15);
    Eigen::VectorXd heights = Eigen::VectorXd(kPoints);
    Moments<4> sums;

    Sample() {
        for (std::uint64_t i = 0; i < kPoints; ++i) {
            const double r = std::sqrt(unit_interval(keyed_hash(1, i, 1)));
            const double a = 2 * M_PI * unit_interval(keyed_hash(1, i, 2)), u = r * std::cos(a),
                         v = r * std::sin(a);
            const auto row = static_cast<Eigen::Index>(i);
            const std::vector<double> four = basis(u, v, 4), eight = basis(u, v, 8);
            heights(row) = height(u, v, i);
            for (std::size_t k = 0; k < 15; ++k) rows(row, static_cast<Eigen::Index>(k)) = four[k];
            for (std::size_t k = 0; k < 45; ++k) sums.monomial[k] += eight[k];
            for (std::size_t k = 0; k < 15; ++k) sums.height[k] += four[k] * heights(row);
            sums.sq_height += heights(row) * heights(row);
        }
    }
};

TEST(NestedDisc, IsTheLeastSquaresOfBothDegrees) {
    const Sample s;
    const auto disc = NestedDisc<4>::solve(s.sums);
    ASSERT_TRUE(disc);
    const Eigen::VectorXd all = s.rows.colPivHouseholderQr().solve(s.heights);
    const Eigen::VectorXd own = s.rows.leftCols(6).colPivHouseholderQr().solve(s.heights);
    const auto found_all = disc->coefficients<15>();
    const auto found_own = disc->coefficients<6>();
    for (std::size_t k = 0; k < 15; ++k)
        EXPECT_NEAR(found_all[k], all(static_cast<Eigen::Index>(k)), 1e-10);
    for (std::size_t k = 0; k < 6; ++k)
        EXPECT_NEAR(found_own[k], own(static_cast<Eigen::Index>(k)), 1e-11);
    EXPECT_NEAR(s.sums.sq_height - disc->sq_explained(), (s.heights - s.rows * all).squaredNorm(),
                1e-9);
}

// Sampled over the core: the variance of the even part of a fit's height is that of phi A^-1 phi.
TEST(NestedDisc, VarianceOfTheEvenTermsOverTheCore) {
    const Sample s;
    const auto disc = NestedDisc<4>::solve(s.sums);
    ASSERT_TRUE(disc);
    const Eigen::MatrixXd all = (s.rows.transpose() * s.rows).inverse();
    const Eigen::MatrixXd own = (s.rows.leftCols(6).transpose() * s.rows.leftCols(6)).inverse();
    double sum_all = 0, sum_own = 0;
    int n = 0;
    for (int i = -100; i <= 100; ++i)
        for (int j = -100; j <= 100; ++j) {
            const double u = kCore * i / 100, v = kCore * j / 100;
            if (u * u + v * v >= kCore * kCore) continue;
            Eigen::VectorXd phi(15);
            const std::vector<double> plus = basis(u, v, 4), minus = basis(-u, -v, 4);
            for (std::size_t k = 0; k < 15; ++k)
                phi(static_cast<Eigen::Index>(k)) = (plus[k] + minus[k]) / 2;
            sum_all += phi.dot(all * phi), sum_own += phi.head(6).dot(own * phi.head(6)), ++n;
        }
    const auto variance = disc->core_variance();
    EXPECT_NEAR(variance.all / (sum_all / n), 1, 1e-3);
    EXPECT_NEAR(variance.own / (sum_own / n), 1, 1e-3);
}

TEST(NestedDisc, RefusesPointsOnALine) {
    Moments<2> sums;
    for (int i = -10; i <= 10; ++i) {
        const double u = i * 0.1;
        for (std::size_t k = 0; k < 15; ++k) sums.monomial[k] += basis(u, 0, 4)[k];
    }
    EXPECT_FALSE(NestedDisc<2>::solve(sums));
}

}  // namespace
}  // namespace slim
