#include "slim/model/weight_kernel.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slim {
namespace {

/// G as a function of x = r / rho, to the letter (NUMERICS 2.3).
double reference(double x) {
    if (x <= 0.5) return std::exp(-8 * x * x);
    if (x >= 1) return 0;
    return 16 * std::exp(-2.0) * std::pow(1 - x, 4);
}

double kernel(double x) { return weight_kernel(x * x); }

TEST(WeightKernel, IsTheGaussianWithASplinedTail) {
    for (int i = 0; i <= 1200; ++i) {
        const double x = i / 1000.0;
        ASSERT_NEAR(kernel(x), reference(x), 6e-9) << x;  // the polynomial's stated error is 5e-9
    }
    EXPECT_NEAR(kernel(0), 1, 6e-9);
}

TEST(WeightKernel, VanishesAtAndBeyondTheSupport) {
    EXPECT_EQ(weight_kernel(1.0), 0);
    EXPECT_EQ(weight_kernel(1.0f), 0);
    EXPECT_EQ(weight_kernel(2.0), 0);  // padding
    EXPECT_EQ(weight_kernel(1e30), 0);
    EXPECT_GT(weight_kernel(0.9999), 0);
    EXPECT_LT(kernel(1 - 1e-3), 3e-12);  // like (1 - x)^4
}

TEST(FitWeight, IsTheKernelOrThePolynomial) {
    for (double s = 0; s < 1.2; s += 0.01) {
        EXPECT_EQ(fit_weight(FitWeight::gauss, s), weight_kernel(s));
        EXPECT_NEAR(fit_weight(FitWeight::polynomial, s), s < 1 ? std::pow(1 - s, 4) : 0, 1e-15);
    }
}

TEST(WeightKernel, ValueSlopeAndCurvatureMatchAtTheJoint) {
    constexpr double h = 1e-3, e2 = 0.13533528323661270;
    const auto slope = [&](double x) { return (kernel(x + h) - kernel(x - h)) / (2 * h); };
    EXPECT_NEAR(kernel(0.5), e2, 6e-9);
    EXPECT_NEAR(kernel(0.5 + 1e-9), e2, 2e-8);
    // One-sided differences; the third derivatives there are 128 e2 and -192 e2.
    const auto second = [&](double at, double step) {
        return (kernel(at) - 2 * kernel(at + step) + kernel(at + 2 * step)) / (step * step);
    };
    EXPECT_NEAR(slope(0.5 - 2 * h), -8 * e2, 0.3);
    EXPECT_NEAR(slope(0.5 + 2 * h), -8 * e2, 0.3);
    EXPECT_NEAR(second(0.5, -h), 48 * e2, 0.2);
    EXPECT_NEAR(second(0.5, h), 48 * e2, 0.2);
}

TEST(WeightKernel, FloatDoubleAndLanesAgree) {
    for (int i = 0; i <= 4000; ++i) {
        const float s = static_cast<float>(i) / 3500.0f;
        const float single = weight_kernel(s);
        ASSERT_NEAR(single, weight_kernel(static_cast<double>(s)), 4e-7) << s;
        FloatV lanes([&](auto lane) { return s + 0.0f * static_cast<float>(lane); });
        const FloatV values = weight_kernel(lanes);
        for (std::size_t k = 0; k < FloatV::size(); ++k) ASSERT_NEAR(values[k], single, 2e-7) << s;
    }
}

TEST(WeightKernel, LanesOnBothSidesOfTheJointDoNotDisturbEachOther) {
    const FloatV s([](auto lane) { return static_cast<float>(lane) * 1.2f / kLanes; });
    const FloatV values = weight_kernel(s);
    for (std::size_t k = 0; k < FloatV::size(); ++k)
        EXPECT_NEAR(values[k], weight_kernel(static_cast<double>(s[k])), 4e-7) << s[k];
}

}  // namespace
}  // namespace slim
