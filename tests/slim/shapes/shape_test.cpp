#include "slim/shapes/shape.h"

#include "slim/base/error.h"
#include "slim/base/hash.h"
#include "tests/slim/shapes/shape_support.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>

namespace slim {
namespace {

using test::at, test::points_near;

constexpr double kDegree = std::numbers::pi / 180;

Vec3d axis_step(std::size_t axis, double h) {
    Vec3d d;
    d[axis] = h;
    return d;
}

class EveryShape : public testing::TestWithParam<std::string> {};

TEST_P(EveryShape, JetsAgreeWithFiniteDifferences) {
    const Shape& shape = find_shape(GetParam());
    constexpr double h = 1e-6;
    std::size_t checked = 0;
    for (const Vec3d& p : points_near(shape, 400)) {
        const Jet2 f = shape.jet(p);
        ASSERT_NEAR(f.value, shape.value(p), 1e-14);
        const std::array<std::array<std::size_t, 3>, 3> at{{{0, 1, 2}, {1, 3, 4}, {2, 4, 5}}};
        double error = 0, scale = 1;
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3d d = axis_step(i, h);
            const Jet2 up = shape.jet(p + d), down = shape.jet(p - d);
            ASSERT_NEAR((shape.value(p + d) - shape.value(p - d)) / (2 * h), f.g[i], 1e-5)
                << p.x << ' ' << p.y << ' ' << p.z;
            for (std::size_t j = 0; j < 3; ++j) {
                const double difference = (up.g[j] - down.g[j]) / (2 * h);
                error = std::max(error, std::abs(difference - f.h[at[i][j]]));
                scale = std::max(scale, std::abs(difference));
            }
        }
        // A crease of the sculpture between the two probes is no error of the jet.
        if (GetParam() == "sculpture" && error > 1e3) continue;
        ASSERT_LT(error, 1e-6 * scale * (1 + scale)) << p.x << ' ' << p.y << ' ' << p.z;
        ++checked;
    }
    EXPECT_GT(checked, 395u);
}

TEST_P(EveryShape, SlopeStaysBelowTheLipschitzBound) {
    const Shape& shape = find_shape(GetParam());
    const Vec3d center = shape.bounds.center();
    const double radius = 0.55 * shape.bounds.diagonal();
    double steepest = 0;
    for (std::uint64_t i = 0; i < 200'000; ++i) {
        const Vec3d u{unit_interval(keyed_hash(1, i)), unit_interval(keyed_hash(2, i)),
                      unit_interval(keyed_hash(3, i))};
        const Vec3d d = (u * 2.0 - Vec3d{1, 1, 1}) * radius;
        const Jet2 f = shape.jet(center + d);
        if (length(d) > radius || f.value < -shape.band) continue;
        steepest = std::max(steepest, length(f.gradient()));
    }
    EXPECT_LE(steepest, shape.lipschitz + 1e-12);
    EXPECT_GE(steepest, 0.3 * shape.lipschitz) << "the bound wastes steps";
}

TEST_P(EveryShape, BoundsHoldTheSurface) {
    const Shape& shape = find_shape(GetParam());
    if (shape.open) return;
    Bbox box;
    for (const Vec3d& p : test::sampled(shape.name, 20'000).positions) box.extend(p);
    // Just outside the box f is positive, and the box is not much too large.
    for (std::uint64_t i = 0; i < 100'000; ++i) {
        Vec3d p = shape.bounds.lo;
        for (std::size_t a = 0; a < 3; ++a)
            p[a] += shape.bounds.extent()[a] * unit_interval(keyed_hash(a, i));
        const std::size_t face = i % 3;
        p[face] = i % 2 ? shape.bounds.lo[face] - 1e-9 : shape.bounds.hi[face] + 1e-9;
        ASSERT_GT(shape.value(p), 0) << p.x << ' ' << p.y << ' ' << p.z;
    }
    EXPECT_GT(box.diagonal(), 0.9 * shape.bounds.diagonal());
}

INSTANTIATE_TEST_SUITE_P(Shapes, EveryShape, testing::ValuesIn(shape_names()),
                         [](const auto& tested) { return tested.param; });

TEST(Curvature, OfASphereIsOneOverTheRadius) {
    const SurfacePoint s = at("sphere", {0.6, 0.0, -0.8});
    EXPECT_NEAR(s.k1, 1, 1e-12);
    EXPECT_NEAR(s.k2, 1, 1e-12);
    EXPECT_NEAR(length(s.normal - Vec3d{0.6, 0.0, -0.8}), 0, 1e-14);
}

TEST(Curvature, OfATorusIsKnownEverywhere) {
    for (double v = 0.1; v < 6.3; v += 0.37) {
        const double rho = 1 + 0.35 * std::cos(v);
        const SurfacePoint s = at("torus", {rho * std::cos(1.0), rho * std::sin(1.0),
                                            0.35 * std::sin(v)});
        EXPECT_NEAR(s.k1, 1 / 0.35, 1e-10);
        EXPECT_NEAR(s.k2, std::cos(v) / rho, 1e-10);
    }
}

TEST(Curvature, OfACylinderAndAConeIsThatOfTheirRings) {
    const SurfacePoint cylinder = at("cylinder", {std::cos(2.0), std::sin(2.0), 0.3});
    EXPECT_NEAR(cylinder.k1, 1, 1e-12);
    EXPECT_NEAR(cylinder.k2, 0, 1e-12);
    const double half_angle = std::atan(0.5), z = 0.2, r = 0.4;
    const SurfacePoint cone = at("cone", {r * std::cos(2.0), r * std::sin(2.0), z});
    EXPECT_NEAR(cone.k1, std::cos(half_angle) / r, 1e-12);
    EXPECT_NEAR(cone.k2, 0, 1e-12);
}

TEST(Curvature, OfAnEllipsoidHasTheClosedFormProduct) {
    const double a = 1, b = 0.7, c = 0.4;
    for (double s = 10 * kDegree; s < 3; s += 0.41) {
        const Vec3d p{a * std::sin(s) * std::cos(0.7), b * std::sin(s) * std::sin(0.7),
                      c * std::cos(s)};
        const double sq_h = 1 / (p.x * p.x / (a * a * a * a) + p.y * p.y / (b * b * b * b) +
                                 p.z * p.z / (c * c * c * c));
        const SurfacePoint q = at("ellipsoid", p);
        EXPECT_NEAR(q.k1 * q.k2, sq_h * sq_h / (a * b * c * a * b * c), 1e-9);
        EXPECT_GT(q.k2, 0);
    }
}

// Principal curvatures of the ring cyclide: 1 / (d - c cos t) and cos p / (d cos p - a) in the
// parametrisation by lines of curvature (checked by the implicit equation at each point).
TEST(Curvature, OfACyclideHasItsClosedForm) {
    const double a = 1, c = 0.3, d = 0.5, b = std::sqrt(a * a - c * c);
    for (double t = 0.05; t < 6.28; t += 0.5)
        for (double p = 0.02; p < 6.28; p += 0.5) {
            const double ct = std::cos(t), cp = std::cos(p), w = a - c * ct * cp;
            const Vec3d x{(d * (c - a * ct * cp) + b * b * ct) / w,
                          b * std::sin(t) * (a - d * cp) / w, b * std::sin(p) * (c * ct - d) / w};
            const double k_tube = 1 / (d - c * ct), k_ring = cp / (d * cp - a);
            const SurfacePoint s = at("cyclide", x);
            EXPECT_NEAR(s.k1, std::max(k_tube, k_ring), 1e-9) << t << ' ' << p;
            EXPECT_NEAR(s.k2, std::min(k_tube, k_ring), 1e-9) << t << ' ' << p;
        }
}

TEST(Curvature, OfAMonkeySaddleVanishesAtTheOriginAndHasItsHessianBeside) {
    const SurfacePoint s = at("monkey", {0, 0, 0});
    EXPECT_NEAR(s.k1, 0, 1e-14);
    EXPECT_NEAR(s.k2, 0, 1e-14);
    // Gauss curvature of a graph: (fxx fyy - fxy^2) / (1 + fx^2 + fy^2)^2 at (0.3, 0.2).
    const double x = 0.3, y = 0.2, fx = 3 * (x * x - y * y), fy = -6 * x * y;
    const SurfacePoint q = at("monkey", {x, y, x * x * x - 3 * x * y * y});
    const double area = 1 + fx * fx + fy * fy;
    EXPECT_NEAR(q.k1 * q.k2, -36 * (x * x + y * y) / (area * area), 1e-12);
}

TEST(Curvature, OfTheBumpySphereSpansThePublishedRange) {
    double k1 = 0, k2 = 0;
    for (const SurfacePoint& s : test::sampled("bumpy", 40'000).truth) {
        k1 = std::max(k1, s.k1);
        k2 = std::min(k2, s.k2);
    }
    EXPECT_NEAR(k1, 3.47, 0.03);
    EXPECT_NEAR(k2, -2.67, 0.03);
}

TEST(FindShape, NamesTheKnownOnes) {
    try {
        find_shape("teapot");
        FAIL() << "a teapot is no shape";
    } catch (const ConfigError& e) {
        EXPECT_NE(std::string(e.what()).find("teapot"), std::string::npos);
        EXPECT_NE(std::string(e.what()).find("sculpture"), std::string::npos);
    }
}

}  // namespace
}  // namespace slim
