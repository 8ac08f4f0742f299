#include "slim/blend/roots.h"

#include "slim/base/hash.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace slim {
namespace {

double uniform(std::uint64_t seed, std::uint64_t i) {
    return 2 * unit_interval(keyed_hash(seed, i)) - 1;
}

/// Roots by brute force: sign changes on a fine grid in long double, then bisection.
std::vector<long double> brute_roots(const RayPolynomial<double>& k, long double lo,
                                     long double hi) {
    const auto f = [&](long double t) {
        return k[0] + t * (k[1] + t * (k[2] + t * static_cast<long double>(k[3])));
    };
    constexpr int kSteps = 4000;
    std::vector<long double> roots;
    for (int i = 0; i < kSteps; ++i) {
        long double a = lo + (hi - lo) * i / kSteps, b = lo + (hi - lo) * (i + 1) / kSteps;
        if ((f(a) < 0) == (f(b) < 0)) continue;
        for (int j = 0; j < 70; ++j) ((f((a + b) / 2) < 0) == (f(a) < 0) ? a : b) = (a + b) / 2;
        roots.push_back((a + b) / 2);
    }
    return roots;
}

/// Distance from a root to the nearest stationary point, where roots are lost and born.
template <class T>
bool has_near_double_root(const RayPolynomial<T>& k, T tolerance) {
    const auto cuts = quadratic_roots(k[1], T(2) * k[2], T(3) * k[3], T(-2), T(2));
    for (int i = 0; i < cuts.n; ++i)
        if (std::abs(ray_value(k, cuts.t[static_cast<std::size_t>(i)])) < tolerance) return true;
    return false;
}

template <class T>
void compare_with_brute_force(double k3_scale, double tolerance, double skip) {
    for (std::uint64_t seed = 0; seed < 2000; ++seed) {
        SCOPED_TRACE(seed);
        RayPolynomial<T> k{};
        for (std::size_t i = 0; i < 4; ++i)
            k[i] = static_cast<T>(uniform(seed, i) * (i == 3 ? k3_scale : 1));
        const T s = static_cast<T>(0.2 + 0.8 * unit_interval(keyed_hash(seed, 9)));
        const RayPolynomial<double> kd{k[0], k[1], k[2], k[3]};
        if (has_near_double_root(k, static_cast<T>(skip)) || std::abs(ray_value(k, s)) < skip ||
            std::abs(ray_value(k, -s)) < skip)
            continue;
        const auto expected = brute_roots(kd, -static_cast<long double>(s), s);
        const auto found = ray_roots(k, -s, s);
        ASSERT_EQ(found.n, static_cast<int>(expected.size()));
        for (std::size_t i = 0; i < expected.size(); ++i)
            ASSERT_NEAR(static_cast<double>(found.t[i]), static_cast<double>(expected[i]),
                        tolerance);
    }
}

TEST(Roots, QuadraticAgreesWithLongDoubleBisection) {
    compare_with_brute_force<double>(0, 1e-11, 1e-4);
    compare_with_brute_force<float>(0, 1e-4, 1e-4);
}

TEST(Roots, CubicAgreesWithLongDoubleBisection) {
    compare_with_brute_force<double>(1, 1e-11, 1e-4);
    compare_with_brute_force<float>(1, 1e-4, 1e-4);
}

TEST(Roots, SmallLeadingCoefficientsLoseNothing) {
    compare_with_brute_force<double>(1e-9, 1e-11, 1e-4);
    const auto roots = quadratic_roots(-0.5, 1.0, 1e-18, -1.0, 1.0);
    ASSERT_EQ(roots.n, 1);
    EXPECT_NEAR(roots.t[0], 0.5, 1e-15);
}

TEST(Roots, GrazingRootIsLimitedByTheSquareRootOfTheRounding) {
    for (int e = 4; e < 60; ++e) {  // (t - 0.25)^2 = gap
        const double gap = std::ldexp(1.0, -e);
        const auto roots = quadratic_roots(0.0625 - gap, -0.5, 1.0, -1.0, 1.0);
        ASSERT_GE(roots.n, 1) << e;
        EXPECT_NEAR(roots.t[0], 0.25 - std::sqrt(gap), 3e-8) << e;
    }
    EXPECT_EQ(quadratic_roots(0.0625 + 1e-3, -0.5, 1.0, -1.0, 1.0).n, 0);
    EXPECT_EQ(quadratic_roots(0.0625f, -0.5f, 1.0f, -1.0f, 1.0f).n, 1);
}

TEST(Roots, DegenerateCoefficientsAreHandled) {
    EXPECT_EQ(ray_roots<double>({0, 0, 0, 0}, -1, 1).n, 0);
    EXPECT_EQ(ray_roots<double>({1, 0, 0, 0}, -1, 1).n, 0);
    EXPECT_EQ(ray_roots<double>({0, 0, 1, 0}, -1, 1).n, 1);
    EXPECT_EQ(ray_roots<double>({0, 0, 0, 1}, -1, 1).n, 1);
    EXPECT_EQ(ray_roots<double>({0, 1, 0, 0}, 0.5, 1).n, 0);
}

TEST(Roots, FirstAndNearestChooseAmongThree) {
    // (t + 0.5) t (t - 0.75)
    const RayPolynomial<double> k{0, -0.375, -0.25, 1};
    const auto roots = ray_roots(k, -1.0, 1.0);
    ASSERT_EQ(roots.n, 3);
    EXPECT_NEAR(*roots.first(), -0.5, 1e-15);
    EXPECT_NEAR(*roots.nearest(0.1), 0.0, 1e-15);
    EXPECT_NEAR(*roots.nearest(5.0), 0.75, 1e-15);
    EXPECT_NEAR(*ray_roots(k, 0.2, 1.0).first(), 0.75, 1e-15);
    EXPECT_FALSE(ray_roots(k, 0.8, 1.0).first());
    EXPECT_FALSE(ray_roots(k, 0.8, 1.0).nearest(0.9));
}

}  // namespace
}  // namespace slim
