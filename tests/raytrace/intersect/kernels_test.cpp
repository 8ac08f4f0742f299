#include "raytrace/intersect/curvature_kernel.h"
#include "raytrace/intersect/root_kernel.h"
#include "slim/base/hash.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace slim {
namespace {

using Lanes = stdx::simd<float, stdx::simd_abi::deduce_t<float, 8>>;
using OneLane = stdx::simd<float, stdx::simd_abi::scalar>;

struct Case {
    std::array<float, 4> k;
    float lo, s, guess;
};

Case random_case(std::uint64_t seed, int degree) {
    const auto uniform = [&](std::uint64_t i) {
        return static_cast<float>(2 * unit_interval(keyed_hash(seed, i)) - 1);
    };
    Case c{};
    for (std::size_t i = 0; i <= static_cast<std::size_t>(degree); ++i) c.k[i] = uniform(i);
    c.s = 0.3f + 0.7f * std::abs(uniform(10));
    c.lo = -c.s + 0.3f * std::max(0.0f, uniform(11));
    c.guess = uniform(12);
    return c;
}

/// Roots in [lo, hi] in doubles: sign changes between the extrema, bisected.
std::vector<double> reference_roots(const Case& c, double lo, double hi) {
    const auto f = [&](double t) {
        return c.k[0] + t * (c.k[1] + t * (c.k[2] + t * static_cast<double>(c.k[3])));
    };
    std::vector<double> roots;
    constexpr int kSteps = 3000;
    for (int i = 0; i < kSteps; ++i) {
        double a = lo + (hi - lo) * i / kSteps, b = lo + (hi - lo) * (i + 1) / kSteps;
        if ((f(a) < 0) == (f(b) < 0)) continue;
        for (int j = 0; j < 50; ++j) ((f((a + b) / 2) < 0) == (f(a) < 0) ? a : b) = (a + b) / 2;
        roots.push_back((a + b) / 2);
    }
    return roots;
}

/// True if a root may come or go by rounding: a stationary value or an end value near zero.
bool is_critical(const Case& c, double lo, double hi) {
    const double k1 = c.k[1], k2 = c.k[2], k3 = c.k[3];
    const auto f = [&](double t) { return c.k[0] + t * (k1 + t * (k2 + t * k3)); };
    double least = std::min(std::abs(f(lo)), std::abs(f(hi)));
    for (int i = 0; i <= 2000; ++i) {
        const double t = -1.2 + 2.4 * i / 2000;
        if (std::abs(k1 + t * (2 * k2 + t * 3 * k3)) < 5e-3)
            least = std::min(least, std::abs(f(t)));
    }
    return least < 2e-3;
}

template <class V>
PolynomialLanes<V> lanes_of(const std::vector<Case>& cases) {
    PolynomialLanes<V> k;
    for (std::size_t i = 0; i < 4; ++i)
        k[i] = V([&](auto lane) { return cases[static_cast<std::size_t>(lane)].k[i]; });
    return k;
}

template <class V, int Degree>
void check_against_reference() {
    int compared = 0;
    for (std::uint64_t batch = 0; batch < 120; ++batch) {
        SCOPED_TRACE(batch);
        std::vector<Case> cases;
        for (std::uint64_t lane = 0; lane < V::size(); ++lane)
            cases.push_back(random_case(batch * 16 + lane, Degree));
        const auto k = lanes_of<V>(cases);
        const auto pick = [&](auto member) {
            return V([&](auto lane) { return cases[static_cast<std::size_t>(lane)].*member; });
        };
        const typename V::mask_type all(true);
        const V lo = pick(&Case::lo), s = pick(&Case::s), guess = pick(&Case::guess);
        const auto first = first_root<Degree, V>(k, lo, s, all);
        const auto nearest = nearest_root<Degree, V>(k, guess, -s, s, all);
        for (std::size_t lane = 0; lane < V::size(); ++lane) {
            const Case& c = cases[lane];
            if (is_critical(c, c.lo, c.s) || is_critical(c, -c.s, c.s)) continue;
            ++compared;
            const auto expected = reference_roots(c, c.lo, c.s);
            ASSERT_EQ(first.hit[lane], !expected.empty());
            if (!expected.empty()) { ASSERT_NEAR(first.t[lane], expected[0], 1e-4); }
            const auto around = reference_roots(c, -c.s, c.s);
            ASSERT_EQ(nearest.hit[lane], !around.empty());
            if (around.empty()) continue;
            double gap = 10;
            for (const double t : around) gap = std::min(gap, std::abs(t - c.guess));
            ASSERT_NEAR(std::abs(nearest.t[lane] - c.guess), gap, 1e-4);
        }
    }
    EXPECT_GT(compared, 60);
}

TEST(RootKernel, AgreesWithBisectionInDoubles) {
    check_against_reference<Lanes, 1>();
    check_against_reference<Lanes, 2>();
    check_against_reference<Lanes, 3>();
    check_against_reference<OneLane, 2>();
    check_against_reference<OneLane, 3>();
}

template <int Degree>
void check_lanes_are_independent() {
    for (std::uint64_t batch = 0; batch < 200; ++batch) {
        std::vector<Case> cases;
        for (std::uint64_t lane = 0; lane < Lanes::size(); ++lane)
            cases.push_back(random_case(batch * 16 + lane, Degree));
        const auto k = lanes_of<Lanes>(cases);
        const auto together = nearest_root<Degree, Lanes>(k, Lanes(0.1f), Lanes(-0.9f), Lanes(0.9f),
                                                          Lanes::mask_type(true));
        for (std::size_t lane = 0; lane < Lanes::size(); ++lane) {
            const auto alone = nearest_root<Degree, OneLane>(
                lanes_of<OneLane>({cases[lane]}), OneLane(0.1f), OneLane(-0.9f), OneLane(0.9f),
                OneLane::mask_type(true));
            ASSERT_EQ(together.hit[lane], alone.hit[0]) << batch << ' ' << lane;
            ASSERT_NEAR(together.t[lane], alone.t[0], 1e-5) << batch << ' ' << lane;
        }
    }
}

TEST(RootKernel, ALaneDoesNotDependOnItsNeighbours) {
    check_lanes_are_independent<2>();
    check_lanes_are_independent<3>();
}

TEST(RootKernel, ReportsNoRootWhereThereIsNone) {
    const typename Lanes::mask_type all(true), none(false);
    const Lanes zero(0.0f), one(1.0f);
    const PolynomialLanes<Lanes> constant{one, zero, zero, zero};
    EXPECT_TRUE(stdx::none_of(first_root<1, Lanes>(constant, -one, one, all).hit));
    EXPECT_TRUE(stdx::none_of(first_root<2, Lanes>(constant, -one, one, all).hit));
    EXPECT_TRUE(stdx::none_of(first_root<3, Lanes>(constant, -one, one, all).hit));
    EXPECT_TRUE(stdx::none_of(nearest_root<3, Lanes>(constant, zero, -one, one, all).hit));
    const PolynomialLanes<Lanes> line{Lanes(0.5f), one, zero, zero};
    EXPECT_TRUE(stdx::all_of(first_root<3, Lanes>(line, -one, one, all).hit));
    EXPECT_TRUE(stdx::none_of(first_root<3, Lanes>(line, -one, one, none).hit));
    // behind the near plane
    EXPECT_TRUE(stdx::none_of(first_root<3, Lanes>(line, one, -one, all).hit));
    const PolynomialLanes<Lanes> touching{Lanes(0.0625f), Lanes(-0.5f), one, zero};
    EXPECT_EQ((first_root<2, Lanes>(touching, -one, one, all).t[0]), 0.25f);
}

TEST(CurvatureKernel, GivesTheTorusItsPrincipalCurvatures) {
    const float big = 2, small = 0.5f;
    for (float b = 0.1f; b < 6.2f; b += 0.37f) {
        const float x = big + small * std::cos(b), z = small * std::sin(b), d = x - big;
        const std::array<OneLane, 6> h{OneLane(2.0f), OneLane(0.0f), OneLane(0.0f),
                                       OneLane(2 * d / x), OneLane(0.0f), OneLane(2.0f)};
        const auto k = curvature_lanes<OneLane>(OneLane(2 * d), OneLane(0.0f), OneLane(2 * z), h);
        const float other = std::cos(b) / x;
        EXPECT_NEAR(k.k1[0], 1 / small, 1e-5f);
        EXPECT_NEAR(k.k2[0], other, 1e-5f);
        EXPECT_NEAR(k.mean[0], (1 / small + other) / 2, 1e-5f);
        EXPECT_NEAR(k.gauss[0], other / small, 1e-5f);
    }
}

}  // namespace
}  // namespace slim
