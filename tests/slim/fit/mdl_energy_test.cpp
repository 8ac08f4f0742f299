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

TEST(MdlEnergy, RoundingOfFloatsIsNoError) {
    // An exact plane that is none of the axes, in the floats of the ladder: its energy is the
    // price alone and falls to the largest ball, whatever the unit.
    const Frame<double> frame = frame_from_normal(normalized(Vec3d{0.3, -0.5, 0.7}));
    for (const double unit : {1.0, 1e-9, 1e9}) {
        const MdlEnergy energy{1e-30 * unit * unit, 0.01 * unit};
        for (const double rho : {0.3 * unit, 0.01 * unit})
            for (int degree = 1; degree <= 3; ++degree) {
                SCOPED_TRACE(testing::Message() << rho << " degree " << degree);
                std::vector<Vec3d> places;
                for (std::uint64_t i = 0; i < 300; ++i)
                    places.push_back((kCenter + frame.u_axis * random_at(1, i) * 0.7 +
                                      frame.v_axis * random_at(2, i) * 0.7) *
                                     rho);
                const PointBlock block =
                    block_of(places, std::vector<Vec3f>(300, to_float(frame.normal)));
                BallPoints<float> ball;
                gather_ball(tree_of(block), kCenter * rho, rho, ball);
                const LocalFit fit = fit_ball(ball, 1, frame, degree);
                EXPECT_GT(fit.sq_error, 0);
                EXPECT_EQ(energy(fit.sq_error, rho), energy.price(rho));
            }
    }
    EXPECT_GT(whole_variance(1e-14, 1), 0);
}

}  // namespace
}  // namespace slim::test
