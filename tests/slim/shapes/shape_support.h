#pragma once

#include "slim/base/hash.h"
#include "slim/shapes/shape.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace slim::test {

/// Random points near the surface, by projecting points of the box and moving off a little.
inline std::vector<Vec3d> points_near(const Shape& shape, std::uint64_t n) {
    std::vector<Vec3d> points;
    test::Cloud cloud = test::sampled(shape.name, n, 7);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        const double off = 0.02 * (unit_interval(mix64(i)) - 0.5);
        points.push_back(cloud.positions[i] + cloud.truth[i].normal * off);
    }
    return points;
}

inline SurfacePoint at(const char* shape, const Vec3d& p) {
    const Jet2 f = find_shape(shape).jet(p);
    EXPECT_NEAR(f.value, 0, 1e-12) << shape;
    return surface_point(f);
}

}  // namespace slim::test
