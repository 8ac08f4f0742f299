#pragma once

#include "slim/base/frame.h"
#include "slim/fit/ball_points.h"
#include "tests/slim/fit/fit_support.h"

#include <cstddef>
#include <cstdint>

namespace slim::test {

inline const Frame<double> kUpright = frame_from_normal(Vec3d{0, 0, 1});
inline const Vec3d kCenter{3, -2, 0.5};

/// The ball about `center` filled by points center + radius (u, v, height(u, v)), |u|,
/// |v| <= extent.
template <class T, class Height>
BallPoints<T> ball_of(std::size_t n, double radius, std::uint64_t seed, Height&& height,
                      double extent = 1) {
    PointBlock block = graph_points(n, extent, seed, height);
    for (Vec3d& p : block.position) p = kCenter + p * radius;
    BallPoints<T> ball;
    gather_ball(tree_of(block), kCenter, radius, ball);
    return ball;
}

}  // namespace slim::test
