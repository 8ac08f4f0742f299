#include "slim/smooth/coordinate_steps.h"

#include "slim/base/hash.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>

namespace slim {
namespace {

double uniform(std::uint64_t i, std::uint64_t key) { return unit_interval(keyed_hash(5, i, key)); }

Vec3d steps_of(std::size_t n, const std::function<Vec3d(std::size_t)>& place) {
    PointBlock block;
    for (std::size_t i = 0; i < n; ++i) block.position.push_back(place(i)), block.id.push_back(i);
    Bbox box;
    for (const Vec3d& p : block.position) box.extend(p);
    sort_along_curve(block, box);
    return coordinate_steps(PointTree(block, morton_order(block, box)));
}

Vec3d on_wave(std::uint64_t i) {
    const double u = 2 * uniform(i, 1) - 1, v = 2 * uniform(i, 2) - 1;
    return {u, v, 0.1 * std::sin(3 * u) * std::cos(2 * v)};
}

double in_steps(double x, double step) { return std::round(x / step) * step; }

TEST(CoordinateSteps, AreThoseThatHeightsWereRoundedTo) {
    for (const double step : {0.01, 1e-4}) {
        const Vec3d found = steps_of(20000, [&](std::size_t i) {
            const Vec3d p = on_wave(i);
            return Vec3d{p.x, p.y, in_steps(p.z, step)};
        });
        EXPECT_NEAR(found.z, step, 1e-6 * step);
        EXPECT_EQ(found.x, 0);
        EXPECT_EQ(found.y, 0);
    }
}

TEST(CoordinateSteps, AreSeenInFloatsFarFromTheOrigin) {
    const Vec3d found = steps_of(20000, [&](std::size_t i) {
        const Vec3d p = on_wave(i);
        const auto far = static_cast<float>(1000 + in_steps(p.z, 0.01));
        return Vec3d{p.x, p.y, far};
    });
    EXPECT_NEAR(found.z, 0.01, 1e-5);
}

TEST(CoordinateSteps, AreNoneOfFreeCoordinatesAndOfAFewFlatPlaces) {
    EXPECT_EQ(steps_of(20000, on_wave), Vec3d{});
    EXPECT_EQ(steps_of(50,
                       [](std::size_t i) {
                           return Vec3d{static_cast<double>(i % 5), 0, 0};
                       }),
              Vec3d{});
    const Vec3d floors = steps_of(2000, [](std::size_t i) {
        return Vec3d{uniform(i, 1), uniform(i, 2), static_cast<double>(i % 3)};
    });
    EXPECT_EQ(floors, Vec3d{});
}

TEST(CoordinateSteps, OfAGridAreNoNoiseButThoseOfItsHeightsAre) {
    const Vec3d found = steps_of(10000, [](std::size_t i) {
        const double u = 0.02 * static_cast<double>(i % 100),
                     v = 0.02 * static_cast<double>(i / 100);
        return Vec3d{u, v, in_steps(0.3 * std::sin(3 * u + v), 0.002)};
    });
    EXPECT_EQ(found.x, 0);
    EXPECT_EQ(found.y, 0);
    EXPECT_NEAR(found.z, 0.002, 1e-6);
}

TEST(CoordinateSteps, AsWideAsPointsAreApartAreRoundingIfSomeFallTogether) {
    const Vec3d found = steps_of(20000, [](std::size_t i) {
        const Vec3d p = on_wave(i);
        return Vec3d{in_steps(p.x, 0.01), in_steps(p.y, 0.01), in_steps(p.z, 0.01)};
    });
    for (const double step : {found.x, found.y, found.z}) EXPECT_NEAR(step, 0.01, 1e-6);
}

TEST(RoundingNoise, IsUniformAlongEachAxis) {
    EXPECT_DOUBLE_EQ(rounding_noise({0, 0, 0.6}, {0, 0, 1}), 0.03);
    EXPECT_DOUBLE_EQ(rounding_noise({0, 0, 0.6}, {0.6, 0, 0.8}), 0.03 * 0.64);
    EXPECT_DOUBLE_EQ(rounding_noise({}, {0, 0, 1}), 0);
}

}  // namespace
}  // namespace slim
