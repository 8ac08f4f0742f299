#include "slim/smooth/wide_fit.h"

#include "slim/base/hash.h"
#include "slim/neighbors/morton.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

namespace slim {
namespace {

double gaussian(std::uint64_t seed, std::uint64_t i) {
    const double u = 1 - unit_interval(keyed_hash(seed, i, 5)),
                 v = unit_interval(keyed_hash(seed, i, 6));
    return std::sqrt(-2 * std::log(u)) * std::cos(2 * M_PI * v);
}

/// Points of z = height(x, y) over [-1, 1]^2 with Gaussian noise in z.
template <class Height>
PointBlock field(std::size_t n, std::uint64_t seed, double noise, const Height& height) {
    PointBlock block;
    for (std::size_t i = 0; i < n; ++i) {
        const double x = 2 * unit_interval(keyed_hash(seed, i, 1)) - 1,
                     y = 2 * unit_interval(keyed_hash(seed, i, 2)) - 1;
        block.position.push_back({x, y, height(x, y) + noise * gaussian(seed, i)});
        block.id.push_back(i);
    }
    return block;
}

std::optional<WideFit> fit(PointBlock block, double radius, double noise, bool ahead,
                           double curvature = 0) {
    Bbox box;
    for (const Vec3d& p : block.position) box.extend(p);
    sort_along_curve(block, box);
    const PointTree tree(block, morton_order(block, box));
    WideWork work;
    return fit_wide(tree, {{}, frame_from_normal(Vec3d{0, 0, 1}), radius, noise, curvature}, ahead,
                    work);
}

double quadratic(double x, double y) { return 0.3 * x * x - 0.2 * x * y + 0.1 * y; }

TEST(WideFit, NeedsAPointNearTheMiddle) {
    PointBlock ring = field(5000, 1, 0.01, quadratic), whole = ring;
    std::size_t n = 0;
    for (std::size_t i = 0; i < ring.size(); ++i)
        if (std::hypot(ring.position[i].x, ring.position[i].y) > 0.3)
            ring.position[n] = ring.position[i], ring.id[n++] = ring.id[i];
    ring.position.resize(n), ring.id.resize(n);
    EXPECT_TRUE(fit(whole, 0.5, 0.01, true));
    EXPECT_FALSE(fit(ring, 0.5, 0.01, true));
    EXPECT_FALSE(fit(ring, 0.5, 0.01, false));
}

TEST(WideFit, NoiseIsNotLostToTheCancellationOfSums) {
    const auto f = fit(field(5000, 1, 1e-6, quadratic), 0.5, 1e-6, true);
    ASSERT_TRUE(f);
    EXPECT_NEAR(std::sqrt(f->sq_noise) / 1e-6, 1, 0.1);
    const auto exact = fit(field(5000, 1, 0, quadratic), 0.5, 0, true);
    ASSERT_TRUE(exact);
    EXPECT_GT(exact->sq_noise, 0);
    EXPECT_LT(exact->sq_noise, 1e-13);
}

TEST(WideFit, KnowsItsVarianceAndSeesNoBiasInAQuadratic) {
    constexpr double kNoise = 0.01;
    double sq = 0, sq_error = 0, sq_bias = 0, sq_noise = 0;
    constexpr int kRuns = 200;
    for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
        const auto f = fit(field(3000, seed, kNoise, quadratic), 0.5, kNoise, true);
        ASSERT_TRUE(f);
        EXPECT_NEAR(f->n, 3000 * M_PI * 0.25 / 4, 120);
        sq += std::pow(f->polynomial.a[0] * 0.5, 2) / kRuns;
        sq_error += f->sq_error / kRuns, sq_bias += f->sq_bias / kRuns,
            sq_noise += f->sq_noise / kRuns;
    }
    EXPECT_NEAR(sq_noise / (kNoise * kNoise), 1, 0.03);
    // The height in the middle varies as 4 / n; over the core a little less.
    EXPECT_NEAR(sq_error * 589 / (kNoise * kNoise), 3.6, 0.4);
    EXPECT_NEAR(sq / sq_error, 1.1, 0.3);
    EXPECT_LT(std::abs(sq_bias), 0.5 * sq_error);
}

TEST(WideFit, MeasuresTheBiasOfAQuartic) {
    // r^4 under equal weights is r^2 - 1/6 to a quadratic: off by -1/6 in the middle,
    // over the core by less.
    const auto f =
        fit(field(20000, 1, 1e-4, [](double x, double y) { return std::pow(x * x + y * y, 2); }),
            0.5, 1e-4, true);
    ASSERT_TRUE(f);
    const double middle = std::pow(0.5, 4) / 6;
    EXPECT_NEAR(std::sqrt(f->sq_bias) / middle, 1 - 3 * kCore * kCore, 0.07);
    EXPECT_NEAR(f->polynomial.a[0] * 0.5 / -middle, 1, 0.07);
}

TEST(WideFit, LiftsTheMiddleByWhatAQuarticAdds) {
    const auto quartic = [](double x, double y) { return std::pow(x * x + y * y, 2); };
    const auto f = fit(field(20000, 1, 1e-4, quartic), 0.5, 1e-4, true);
    ASSERT_TRUE(f);
    // Off by r^4 - r^2 + 1/6; under the blend's weight over half the radius the mean of r^2 is
    // 0.028, that of r^4 0.0015.
    EXPECT_NEAR(f->lift / std::pow(0.5, 4), 1.0 / 6 - 0.028 + 0.0015, 0.007);
    EXPECT_LT(std::sqrt(f->sq_lift_error), 0.01 * f->lift);
    const auto none = fit(field(20000, 1, 1e-4, quadratic), 0.5, 1e-4, true);
    ASSERT_TRUE(none);
    EXPECT_LT(std::abs(none->lift), 5 * std::sqrt(none->sq_lift_error));
}

TEST(WideFit, KnowsWhatACubicDoesToItsSlopes) {
    // u^3 under equal weights is R^2 / 2 u to a line (its fourth moment over its second): the slope
    // in the middle is off by that, and is none.
    const auto f =
        fit(field(20000, 1, 1e-4, [](double x, double) { return x * x * x; }), 0.5, 1e-4, true);
    ASSERT_TRUE(f);
    EXPECT_NEAR(f->polynomial.a[1], 0.5 * 0.25, 0.012);
    EXPECT_NEAR(f->polynomial.a[1] + f->turn[0], 0, 0.002);
    double sq = 0, error = 0;
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        const auto noisy = fit(field(3000, seed, 0.01, quadratic), 0.5, 0.01, true);
        ASSERT_TRUE(noisy);
        sq += std::pow(noisy->turn[0], 2) + std::pow(noisy->turn[1], 2),
            error += noisy->sq_turn_error;
    }
    EXPECT_NEAR(sq / error, 1, 0.25);
}

TEST(WideFit, DoesNotCutOffWhatBendsAway) {
    const auto bowl = [](double x, double y) { return -(x * x + y * y); };
    const auto f = fit(field(5000, 1, 1e-3, bowl), 0.5, 1e-3, true, 2);
    ASSERT_TRUE(f);
    EXPECT_NEAR(f->n, 5000 * M_PI * 0.25 / 4, 120);
    EXPECT_NEAR(largest_curvature(f->polynomial, 0.5), 2, 0.02);
    EXPECT_NEAR(f->sq_stretch(), 1.5, 0.02);  // slope 2 r, its square's mean 1/2
}

TEST(WideFit, DoesNotCutThickNoiseOff) {
    double sq_noise = 0;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const auto f = fit(field(5000, seed, 0.1, quadratic), 0.25, 0.1, true);
        ASSERT_TRUE(f);
        sq_noise += f->sq_noise / 20;
    }
    EXPECT_NEAR(sq_noise / 0.01, 1, 0.05);
}

TEST(WideFit, RefusesTooFewPointsAndLines) {
    EXPECT_FALSE(fit(field(300, 1, 0.01, quadratic), 0.2, 0.01, true));
    PointBlock line;
    for (std::size_t i = 0; i < 500; ++i) {
        line.position.push_back({static_cast<double>(i) / 500, 0, 0});
        line.id.push_back(i);
    }
    EXPECT_FALSE(fit(line, 0.9, 0.01, false));
}

TEST(WideFit, APlaceOffTheSurfaceIsPutOnIt) {
    WideFit f;
    f.polynomial.a = {0.2, 0.5};
    WideDisc disc{{1, 2, 3}, frame_from_normal(Vec3d{0, 0, 1}), 2, 10};
    EXPECT_FALSE(put_on(f, disc));
    disc.noise = 0.1;
    EXPECT_TRUE(put_on(f, disc));
    EXPECT_NEAR(disc.center.z, 3.4, 1e-12);
    const Vec3d turned = frame_from_normal(Vec3d{0, 0, 1}).world_from_local({-0.5, 0, 1});
    EXPECT_NEAR(length(disc.frame.normal - normalized(turned)), 0, 1e-12);
}

}  // namespace
}  // namespace slim
