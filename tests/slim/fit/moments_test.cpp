#include "slim/fit/moments.h"

#include "slim/base/hash.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

namespace slim {
namespace {

template <class T>
BallPoints<T> ball_of(std::size_t n) {
    BallPoints<T> ball;
    ball.n = n, ball.radius = 1;
    for (auto* a : {&ball.x, &ball.y, &ball.z, &ball.sq}) a->assign(ball.padded(), T(0));
    const auto random = [](std::size_t i, std::uint64_t axis) {
        return static_cast<double>(keyed_hash(3, i, axis) >> 11) * 0x1.0p-53 - 0.5;
    };
    for (std::size_t i = 0; i < ball.padded(); ++i) {
        ball.sq[i] = T(2);
        if (i >= n) continue;
        ball.x[i] = T(random(i, 1)), ball.y[i] = T(random(i, 2)), ball.z[i] = T(0.2 * random(i, 3));
        ball.sq[i] = ball.x[i] * ball.x[i] + ball.y[i] * ball.y[i] + ball.z[i] * ball.z[i];
    }
    return ball;
}

/// Point by point in doubles.
template <int Degree, class T>
Moments<Degree> plain_moments(const BallPoints<T>& ball, const Frame<double>& frame,
                              double shrink) {
    Moments<Degree> out;
    for (std::size_t i = 0; i < ball.n; ++i) {
        const Vec3d p =
            frame.local_from_world(Vec3d{double(ball.x[i]), double(ball.y[i]), double(ball.z[i])});
        const double g =
            fit_weight(ball.weight, static_cast<double>(ball.sq[i]) / (shrink * shrink));
        std::size_t k = 0;
        for (int d = 0; d <= 2 * Degree; ++d)
            for (int b = 0; b <= d; ++b, ++k) {
                const double m = g * std::pow(p.x, d - b) * std::pow(p.y, b);
                out.monomial[k] += m;
                if (d <= Degree) out.height[k] += m * p.z;
            }
        out.sq_height += g * p.z * p.z, out.sq_weight += g * g;
    }
    return out;
}

template <int Degree, class T>
void expect_moments(double tolerance) {
    const Frame<double> frame = frame_from_normal(normalized(Vec3d{0.3, -0.2, 0.9}));
    // A group that is not full, one flush of lanes, more than one and a rest.
    for (const std::size_t n : {std::size_t{5}, std::size_t{256}, std::size_t{700}}) {
        const auto ball = ball_of<T>(n);
        const auto found = accumulate_moments<Degree>(ball, frame, 0.9);
        const auto wanted = plain_moments<Degree>(ball, frame, 0.9);
        const double most = tolerance * wanted.weight();
        for (std::size_t k = 0; k < found.monomial.size(); ++k)
            EXPECT_NEAR(found.monomial[k], wanted.monomial[k], most)
                << Degree << " " << n << " " << k;
        for (std::size_t k = 0; k < found.height.size(); ++k)
            EXPECT_NEAR(found.height[k], wanted.height[k], most) << Degree << " " << n << " " << k;
        EXPECT_NEAR(found.sq_height, wanted.sq_height, most);
        EXPECT_NEAR(found.sq_weight, wanted.sq_weight, most);
    }
}

TEST(Moments, AreSumsOverThePoints) {
    // G's polynomial is exact to 5e-9 either way
    expect_moments<1, double>(1e-8), expect_moments<2, double>(1e-8);
    expect_moments<3, double>(1e-8), expect_moments<4, double>(1e-8);
    expect_moments<1, float>(2e-6), expect_moments<2, float>(2e-6);
    expect_moments<3, float>(2e-6), expect_moments<4, float>(2e-6);
}

}  // namespace
}  // namespace slim
