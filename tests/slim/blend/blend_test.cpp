#include "slim/blend/blend.h"

#include "slim/base/hash.h"
#include "slim/model/weight_kernel.h"
#include "tests/slim/blend/blend_support.h"

#include <gtest/gtest.h>

#include <numbers>

namespace slim {
namespace {

using test::random_cubic, test::random_unit;

double surfel_function(const Surfel& s, const Vec3d& x) {
    const Vec3d q = s.frame.local_from_world((x - s.center) / s.support_radius);
    return q.z - s.polynomial.value(q.x, q.y);
}

TEST(RaySurfel, PolynomialIsTheFunctionAlongTheRay) {
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        SCOPED_TRACE(seed);
        const Surfel s = random_cubic(seed);
        const Ray ray{s.center + random_unit(seed + 1) * 3.0, random_unit(seed + 2)};
        const LocalRay local = local_ray(ray, s);
        const auto k = ray_polynomial(local, s.polynomial);
        for (const double t : {-0.9, 0.0, 0.3, 1.0}) {
            const double world_t = local.t_base + s.support_radius * t;
            const double f = surfel_function(s, ray.origin + ray.direction * world_t);
            ASSERT_NEAR(ray_value(k, t), f, 1e-11 * (1 + std::abs(f)));
        }
    }
}

TEST(RaySurfel, NothingIsHitOrBlendedBeyondTheRim) {
    Surfel s{{0, 0, 0}, 1, frame_from_normal(Vec3d{0, 0, 1}), {}, 2};
    const Rim rim = unpack_rim(s.rims.first = pack_rim(0, 0.24));
    const Vec3d out = s.frame.u_axis * rim.u + s.frame.v_axis * rim.v;
    const auto at = [&](double reach) { return Ray{out * reach + Vec3d{0, 0, 2}, {0, 0, -1}}; };
    const auto weight_at = [&](double reach) {
        BlendSums sums;
        add_supporter(at(reach), 2, {Vec3d{0, 0, 1}}, s, Derivatives::first, sums);
        return sums.weight;
    };
    Vec3d gradient;
    EXPECT_TRUE(first_hit(at(0.23), s, 0, kHitTrim, gradient));
    EXPECT_FALSE(first_hit(at(0.25), s, 0, kHitTrim, gradient));
    EXPECT_TRUE(first_hit(at(-0.5), s, 0, kHitTrim, gradient));
    EXPECT_EQ(weight_at(0.25), 0);
    EXPECT_GT(weight_at(0.23), 0);
    EXPECT_LT(weight_at(0.23), 0.2 * weight_at(0.13));  // no step: it fades over kRimRamp
}

TEST(RaySurfel, SaysThatRaysPassOverItOnlyOnItsOwnSideAndNear) {
    // A dome: w = -(u^2 + v^2) / 2.
    Surfel s{{0, 0, 0}, 1, frame_from_normal(Vec3d{0, 0, 1}), {}, 2};
    s.polynomial.a[3] = s.polynomial.a[5] = -0.5;
    const Gate up(Vec3d{0, 0.1, 1}), down(Vec3d{0, 0, -1});
    const auto over = [&](double height, const Gate& gate) {
        return passing_weight({{-3, 0, height}, {1, 0, 0}}, 3, gate, s);
    };
    EXPECT_NEAR(over(0.1, up), weight_kernel(0.01), 1e-12);
    EXPECT_EQ(over(0.1, down), 0);   // another sheet's hit
    EXPECT_EQ(over(1.1, up), 0);     // out of the ball
    EXPECT_EQ(over(-0.02, up), 0);   // through it
    const Ray steep{{0, 0, 3}, {0, 0, -1}};
    EXPECT_EQ(passing_weight(steep, 2.8, up, s), 0);  // its own root is near
    EXPECT_GT(passing_weight(steep, 2.5, up, s), 0);  // far above it
}

TEST(RaySurfel, FirstHitLiesOnTheSurfelInsideTheTrimmedBall) {
    int hits = 0;
    for (std::uint64_t seed = 0; seed < 500; ++seed) {
        const Surfel s = random_cubic(seed);
        const Vec3d eye = s.center + random_unit(seed + 1) * 3.0;
        const Ray ray{eye, normalized(s.center + random_unit(seed + 5) * 0.2 - eye)};
        Vec3d gradient;
        const auto t = first_hit(ray, s, 0, kTrim, gradient);
        if (!t) continue;
        ++hits;
        const Vec3d q = ray.origin + ray.direction * *t;
        ASSERT_NEAR(surfel_function(s, q), 0, 1e-12);
        ASSERT_LE(length(q - s.center), kTrim * s.support_radius * (1 + 1e-12));
        const double h = 1e-5;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            Vec3d e;
            e[axis] = h;
            const double difference =
                (surfel_function(s, q + e) - surfel_function(s, q - e)) / (2 * h);
            ASSERT_NEAR(gradient[axis], s.support_radius * difference, 1e-8);
        }
        EXPECT_FALSE(first_hit(ray, s, *t + 2 * s.support_radius, kTrim, gradient));
    }
    EXPECT_GT(hits, 200);
}

TEST(Blend, ASheetFartherOffThanPointsBelongToIsNotBlended) {
    // Two parallel planes, both facing up, whose balls hold the point between them.
    const Frame<double> up = frame_from_normal(Vec3d{0, 0, 1});
    const Surfel here{{0, 0, 0}, 1, up, {}, 1};
    for (const double gap : {0.25, 0.35}) {
        SCOPED_TRACE(gap);
        const Surfel other{{0.2, 0, gap}, 1, up, {}, 1};
        const Surfel* both[] = {&here, &other};
        const auto hit = project_along({0.1, 0, 0}, {0, 0, 1}, both);
        ASSERT_TRUE(hit);
        EXPECT_EQ(hit->n_supporters, gap < kBelongs ? 2 : 1);
        if (gap > kBelongs) EXPECT_EQ(hit->t, 0);
        else EXPECT_GT(hit->t, 0.05);
    }
}

TEST(Curvature, OfATorusMatchesItsClosedForm) {
    const double big = 2, small = 0.5;
    for (double b = 0.1; b < 6.2; b += 0.37) {
        // Implicit torus at angle b of the tube, in the plane y = 0:
        // F = (sqrt(x^2+y^2) - R)^2 + z^2.
        const double x = big + small * std::cos(b), z = small * std::sin(b), d = x - big;
        const Vec3d gradient{2 * d, 0, 2 * z};
        const SymmetricMatrix h{2, 0, 0, 2 * d / x, 0, 2};
        const Curvature k = curvature_from(gradient, h);
        const double other = std::cos(b) / x;
        EXPECT_NEAR(k.k1, std::max(1 / small, other), 1e-12);
        EXPECT_NEAR(k.k2, std::min(1 / small, other), 1e-12);
        EXPECT_NEAR(k.mean, (1 / small + other) / 2, 1e-12);
        EXPECT_NEAR(k.gauss, other / small, 1e-12);
    }
}

TEST(Curvature, DoesNotCancelAtAnUmbilic) {
    const Curvature k = curvature_from({0, 0, 1}, {1, 0, 0, 1 + 1e-13, 0, 0});
    EXPECT_NEAR(k.k1 - k.k2, 1e-13, 1e-15);
}

}  // namespace
}  // namespace slim
