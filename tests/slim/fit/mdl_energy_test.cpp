#include "slim/fit/mdl_energy.h"

#include "tests/slim/fit/ball_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

namespace slim::test {
namespace {

TEST(MdlEnergy, SeesTheWholeOfNoiseThatTheBallCutsOff) {
    // Balls from 20 down to 6 times the noise: the weight along the normal hides 4 to 31 % of the
    // variance.
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
    EXPECT_DOUBLE_EQ(energy.upper_bound(fit, 0.1),
                     energy(3e-5, 0.1) + 2 * whole * std::sqrt(2.0 / 50));
    fit.n_effective = 1;
    EXPECT_TRUE(std::isfinite(energy.upper_bound(fit, 0.1)));
}

}  // namespace
}  // namespace slim::test
