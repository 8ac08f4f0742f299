#include "slim/smooth/lifted_fits.h"

#include "slim/base/hash.h"
#include "slim/base/parallel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

namespace slim {
namespace {

constexpr double kRadius = 0.4;

Frame<double> facing(double z) { return frame_from_normal(Vec3d{0, 0, z}); }

/// Fits a quarter of a radius apart over a plane, their lifts known but for noise.
std::vector<std::vector<PlacedFit>> grid(double lift, double noise) {
    std::vector<std::vector<PlacedFit>> out(21);
    for (int i = 0; i < 21; ++i)
        for (int j = 0; j < 21; ++j) {
            const auto key = static_cast<std::uint64_t>(21 * i + j);
            const double off = noise * (2 * unit_interval(keyed_hash(1, key, 3)) - 1);
            out[static_cast<std::size_t>(i)].push_back(
                {{{0.1 * i, 0.1 * j, 0}, 0.5 * kRadius, facing(1), {}, 2},
                 kRadius,
                 lift + off,
                 noise * noise / 3,
                 0,
                 {},
                 0});
        }
    return out;
}

double height(const PlacedFit& f) { return f.surfel.polynomial.a[0] * f.surfel.support_radius; }

TEST(LiftFits, NeighboursKnowAFitsBiasBetterThanItself) {
    auto fits = grid(0.01, 0.02);
    lift_fits(fits);
    for (const auto& row : fits)
        for (const PlacedFit& f : row) EXPECT_NEAR(height(f), 0.01, 0.004);
}

TEST(LiftFits, ABiasGrowsWithTheFourthPowerOfTheRadius) {
    auto fits = grid(0.016, 1e-6);
    fits[10][10].radius = kRadius / 2;
    fits[10][10].lift = 0.001;
    lift_fits(fits);
    EXPECT_NEAR(height(fits[10][10]), 0.001, 1e-5);
    EXPECT_NEAR(height(fits[10][11]), 0.016, 1e-5);
}

TEST(LiftFits, AFitThatDoesNotKnowItsBiasHasItsNeighbours) {
    auto fits = grid(0.01, 1e-6);
    fits[5][5].sq_lift_error = 0, fits[5][5].lift = 7;
    lift_fits(fits);
    EXPECT_NEAR(height(fits[5][5]), 0.01, 1e-5);
    std::vector<std::vector<PlacedFit>> alone(1);
    alone[0].push_back(grid(0, 0)[0][0]);
    lift_fits(alone);
    EXPECT_EQ(height(alone[0][0]), 0);
}

TEST(LiftFits, ASheetThatFacesAwayDoesNotShare) {
    auto fits = grid(0.01, 1e-6);
    auto back = grid(-0.03, 1e-6);
    for (auto& row : back)
        for (PlacedFit& f : row) f.surfel.frame = facing(-1), f.surfel.center.z = -0.01;
    fits.insert(fits.end(), back.begin(), back.end());
    lift_fits(fits);
    EXPECT_NEAR(height(fits[10][10]), 0.01, 1e-5);
    EXPECT_NEAR(height(fits[31][10]), -0.03, 1e-5);
}

TEST(LiftFits, SlopesTurnByWhatIsNotNoiseInThem) {
    for (const double size : {0.1, 0.01}) {
        auto fits = grid(0, 1e-6);
        double n = 0;
        for (auto& row : fits)
            for (PlacedFit& f : row)
                f.turn = {std::fmod(++n, 2) > 0 ? size : -size, 0}, f.sq_turn_error = 1e-4;
        lift_fits(fits);
        // Of squares of 0.01 a hundredth is noise; of 0.0001 all.
        const double share = size > 0.05 ? 0.97 : 0;
        for (const auto& row : fits)
            for (const PlacedFit& f : row)
                EXPECT_NEAR(f.surfel.polynomial.a[1], share * f.turn[0], 1e-5);
    }
}

TEST(LiftFits, TheSameForAnyNumberOfThreads) {
    auto many = grid(0.01, 0.02), few = many;
    lift_fits(many);
    const ThreadLimit one(1);
    lift_fits(few);
    for (std::size_t i = 0; i < many.size(); ++i)
        for (std::size_t j = 0; j < many[i].size(); ++j)
            EXPECT_EQ(height(many[i][j]), height(few[i][j]));
}

TEST(HeightByNoiseOfFeet, IsTheVarianceTimesTheMeanCurvature) {
    WideFit fit;
    fit.sq_noise = 0.01;
    // over a radius of 0.5: both curvatures -0.04
    fit.polynomial.a[3] = fit.polynomial.a[5] = -0.01;
    EXPECT_NEAR(height_by_noise_of_feet(fit, 0.5), -0.04 * 0.01, 1e-6);
}

}  // namespace
}  // namespace slim
