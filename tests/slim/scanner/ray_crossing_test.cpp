#include "slim/scanner/ray_crossing.h"

#include "slim/base/hash.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slim {
namespace {

Vec3d random_point(std::uint64_t key, double radius) {
    return Vec3d{2 * unit_interval(keyed_hash(1, key)) - 1,
                 2 * unit_interval(keyed_hash(2, key)) - 1,
                 2 * unit_interval(keyed_hash(3, key)) - 1} *
           radius;
}

TEST(NextCrossing, AgreesWithTheRootsOfASphere) {
    const Shape& sphere = find_shape("sphere");
    std::size_t hits = 0;
    for (std::uint64_t i = 0; i < 2'000; ++i) {
        const Vec3d origin = normalized(random_point(i, 1)) * 3.0;
        const Ray ray{origin, normalized(random_point(i + 10'000, 1.2) - origin)};
        const double b = dot(origin, ray.direction), q = b * b - sq_length(origin) + 1;
        if (std::abs(q) < 1e-6) continue;  // chords that the march may pass over
        const auto crossing = next_crossing(sphere, ray, clip_to_shape(ray, sphere));
        ASSERT_EQ(crossing.has_value(), q > 0);
        if (!crossing) continue;
        ++hits;
        EXPECT_TRUE(crossing->entering);
        EXPECT_NEAR(crossing->t, -b - std::sqrt(q), 1e-12 / std::sqrt(q));
        const auto out = next_crossing(sphere, ray, {crossing->t + 1e-9, 10});
        ASSERT_TRUE(out);
        EXPECT_FALSE(out->entering);
        EXPECT_NEAR(out->t, -b + std::sqrt(q), 1e-12 / std::sqrt(q));
    }
    EXPECT_GT(hits, 500u);
}

// Brute force: the first sign change in steps a tenth of the thinnest feature.
TEST(NextCrossing, FindsTheFirstOfManySheetsOfTheSculpture) {
    const Shape& shape = find_shape("sculpture");
    const double step = 5e-4;
    std::size_t hits = 0;
    for (std::uint64_t i = 0; i < 300; ++i) {
        const Vec3d origin = normalized(random_point(i, 1)) * 3.0;
        const Ray ray{origin, normalized(random_point(i + 10'000, 0.8) - origin)};
        const Interval part = clip_to_shape(ray, shape);
        const auto crossing = next_crossing(shape, ray, part);
        double t = part.begin;
        while (t < part.end && shape.value(ray.at(t)) > 0) t += step;
        const bool found = t < part.end && !part.empty();
        if (!crossing) {
            EXPECT_FALSE(found) << "ray " << i;
            continue;
        }
        ++hits;
        // Brute force may step over an edge, the march may not find something later than it.
        EXPECT_LT(crossing->t, t + 1e-12) << "ray " << i;
        if (found) {
            EXPECT_GT(crossing->t, t - 50 * step) << "ray " << i;
        }
    }
    EXPECT_GT(hits, 80u);
}

TEST(ConeClearance, StaysShortOfEveryHitInTheCone) {
    const Shape& shape = find_shape("sculpture");
    const Vec3d origin{0.5, 0.4, 4};
    const double slope = 0.01;
    std::size_t hits = 0;
    for (std::uint64_t i = 0; i < 200; ++i) {
        const Ray middle{origin, normalized(random_point(i, 0.7) - origin)};
        const Interval ball = clip_to_ball(middle, shape.bounds.center(), 2);
        const double clear = cone_clearance(shape, middle, ball, slope);
        for (std::uint64_t k = 0; k < 20; ++k) {
            const Vec3d aside = random_point(1'000 * i + k, slope / std::sqrt(3.0));
            const Ray ray{origin, normalized(middle.direction + aside)};
            const auto crossing = next_crossing(shape, ray, clip_to_shape(ray, shape));
            if (!crossing) continue;
            ++hits;
            EXPECT_GT(crossing->t, clear * 0.9999);
        }
    }
    EXPECT_GT(hits, 1'000u);
}

}  // namespace
}  // namespace slim
