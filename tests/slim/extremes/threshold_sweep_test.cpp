#include "tests/slim/extremes/extremes_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <ostream>
#include <string>

namespace slim::test {
namespace {

/// A range of T_MDL in which no radius is cut off, below by the least number of points of a ball,
/// above by the root: there the whole build follows NUMERICS 3.2 with eps^2 = C rho^2p.
struct Sweep {
    const char* shape;
    int degree;
    int p;  ///< d + 1; 4 for quadrics on a sphere, which has no third-order part
    double t_lo, t_hi;
};

void PrintTo(const Sweep& s, std::ostream* out) {
    *out << s.shape << " of degree " << s.degree << ", T " << s.t_lo << " to " << s.t_hi;
}

class ThresholdSweep : public testing::TestWithParam<Sweep> {};

TEST_P(ThresholdSweep, FollowsTheTheoreticalExponents) {
    const Sweep& sweep = GetParam();
    const Cloud cloud = sampled(sweep.shape, 100000);
    const PointBlock block = block_of(cloud);
    const Built fine(block, sweep.t_lo, sweep.degree), coarse(block, sweep.t_hi, sweep.degree);
    const double step = std::log(sweep.t_hi / sweep.t_lo), p = sweep.p;
    const auto exponent = [&](double a, double b) { return std::log(b / a) / step; };
    // E has its minimum at rho ~ T^(1 / (p + 1)). What is left over: the next order of the error, a
    // few percent of log 8 = 2.08 at these radii.
    EXPECT_NEAR(exponent(fine.median_radius(), coarse.median_radius()), 1 / (p + 1), 0.02);
    // Leaves ~ rho^-2; the number of balls that fill a curved surface is theirs within a few
    // percent more.
    EXPECT_NEAR(exponent(fine.leaf_count(), coarse.leaf_count()), -2 / (p + 1), 0.05);
    // The distance of the points to the blend, as eps, is of order rho^p.
    const ModelErrors a = fine.errors(cloud), b = coarse.errors(cloud);
    EXPECT_EQ(a.missed + b.missed, 0u);
    EXPECT_NEAR(exponent(a.distance, b.distance), p / (p + 1), 0.05);
    EXPECT_EQ(fine.counts().degrees[static_cast<std::size_t>(sweep.degree)], fine.counts().leaves);
    // The flattest places of the ellipsoid touch the root.
    EXPECT_LE(coarse.counts().saturated, coarse.counts().leaves / 100);
}

INSTANTIATE_TEST_SUITE_P(
    Convergence, ThresholdSweep,
    testing::Values(Sweep{"sphere", 1, 2, 0.25, 2}, Sweep{"sphere", 2, 4, 0.002, 0.016},
                    Sweep{"sphere", 3, 4, 0.002, 0.016}, Sweep{"torus", 1, 2, 0.25, 2},
                    Sweep{"torus", 2, 3, 0.005, 0.04}, Sweep{"torus", 3, 4, 0.002, 0.016},
                    Sweep{"ellipsoid", 1, 2, 0.25, 2}, Sweep{"ellipsoid", 2, 3, 0.0075, 0.06},
                    Sweep{"ellipsoid", 3, 4, 0.001, 0.008}),
    [](const auto& sweep) {
        return std::string(sweep.param.shape) + "Degree" + std::to_string(sweep.param.degree);
    });

}  // namespace
}  // namespace slim::test
