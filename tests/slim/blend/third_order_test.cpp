#include "slim/blend/blend.h"
#include "slim/blend/curvature.h"
#include "slim/shapes/shape.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slim {
namespace {

/// Third derivatives of a shape's function by central differences of its exact Hessian.
SymmetricTensor third_by_differences(const Shape& shape, const Vec3d& p) {
    constexpr double kStep = 1e-5;
    const auto slope = [&](std::size_t axis, std::size_t entry) {
        Vec3d a = p, b = p;
        a[axis] -= kStep, b[axis] += kStep;
        return (shape.jet(b).h[entry] - shape.jet(a).h[entry]) / (2 * kStep);
    };
    // xx xy xz yy yz zz by x, then yy yz zz by y, then zz by z.
    return {slope(0, 0), slope(0, 1), slope(0, 2), slope(0, 3), slope(0, 4),
            slope(0, 5), slope(1, 3), slope(1, 4), slope(1, 5), slope(2, 5)};
}

ThirdOrder third_order_of(const Shape& shape, const Vec3d& p) {
    const Jet2 f = shape.jet(p);
    return third_order_from(f.gradient(), f.h, third_by_differences(shape, p));
}

TEST(ThirdOrder, OfATorusIsAsInNumericsRow12) {
    const Shape& torus = find_shape("torus");
    const double big = 1, small = 0.35;
    for (const double b : {0.3, 1.0, 1.5, 2.0, 2.9, -1.2}) {
        const double ring = big + small * std::cos(b), turn = 0.7;
        const Vec3d out{std::cos(turn), std::sin(turn), 0};
        const Vec3d p = out * ring + Vec3d{0, 0, small * std::sin(b)};
        const Vec3d tube = out * -std::sin(b) + Vec3d{0, 0, std::cos(b)};
        const ThirdOrder t = third_order_of(torus, p);
        const double along = dot(t.t1, tube);
        EXPECT_NEAR(std::abs(along), 1, 1e-6);
        EXPECT_NEAR(t.e1, 0, 1e-4);
        EXPECT_NEAR(t.e2, 0, 1e-4);
        EXPECT_NEAR(t.k2_along_t1, -along * big * std::sin(b) / (small * ring * ring), 1e-4);
    }
}

TEST(ThirdOrder, AgreesWithDifferencesOfTheCurvature) {
    const Shape& shape = find_shape("ellipsoid");
    const Vec3d on = Vec3d{0.55, 0.45, 0};  // and z from the surface
    const double z = 0.4 * std::sqrt(1 - on.x * on.x - on.y * on.y / 0.49);
    const Vec3d p{on.x, on.y, z};
    const Jet2 f = shape.jet(p);
    const ThirdOrder t = third_order_of(shape, p);
    // Along the surface: a step in the tangent plane, put back by Newton's method.
    const auto k_at = [&](const Vec3d& step) {
        Vec3d q = p + step;
        for (int i = 0; i < 20; ++i) {
            const Jet2 g = shape.jet(q);
            q -= g.gradient() * (g.value / sq_length(g.gradient()));
        }
        const Jet2 g = shape.jet(q);
        return curvature_from(g.gradient(), g.h);
    };
    EXPECT_NEAR(f.value, 0, 1e-9);
    const double h = 1e-4;
    EXPECT_NEAR(t.e1, (k_at(t.t1 * h).k1 - k_at(t.t1 * -h).k1) / (2 * h), 1e-3);
    EXPECT_NEAR(t.k1_along_t2, (k_at(t.t2 * h).k1 - k_at(t.t2 * -h).k1) / (2 * h), 1e-3);
    EXPECT_NEAR(t.k2_along_t1, (k_at(t.t1 * h).k2 - k_at(t.t1 * -h).k2) / (2 * h), 1e-3);
    EXPECT_NEAR(t.e2, (k_at(t.t2 * h).k2 - k_at(t.t2 * -h).k2) / (2 * h), 1e-3);
}

TEST(AddSupporter, SumsThirdDerivativesOnlyIfAsked) {
    Surfel s{{0, 0, 0}, 2, frame_from_normal(normalized(Vec3d{1, 2, 3})), {}, 3};
    s.polynomial.a[6] = 0.3, s.polynomial.a[7] = -0.2, s.polynomial.a[8] = 0.1,
    s.polynomial.a[9] = 0.4;
    const Vec3d n = s.frame.normal;
    BlendSums second, third;
    ASSERT_TRUE(add_supporter({n * 3, -n}, 3, Gate(n), s, Derivatives::second, second));
    ASSERT_TRUE(add_supporter({n * 3, -n}, 3, Gate(n), s, Derivatives::third, third));
    EXPECT_EQ(second.third, SymmetricTensor{});
    const Vec3d u = s.frame.u_axis, v = s.frame.v_axis;
    const auto along = [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
        return dot(times(times(third.third, a), b), c) / third.weight;
    };
    EXPECT_NEAR(along(u, u, u), -6 * 0.3 / 4, 1e-12);
    EXPECT_NEAR(along(u, u, v), 2 * 0.2 / 4, 1e-12);
    EXPECT_NEAR(along(u, v, v), -2 * 0.1 / 4, 1e-12);
    EXPECT_NEAR(along(v, v, v), -6 * 0.4 / 4, 1e-12);
    EXPECT_NEAR(along(u, v, n), 0, 1e-12);
}

}  // namespace
}  // namespace slim
