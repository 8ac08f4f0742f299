#pragma once

#include "slim/fit/ball_points.h"

#include <cstddef>
#include <vector>

namespace slim {

/// Average normal of a ball: sum G n_i over the points on the side of `side` (the centre's own
/// normal), weights at |x| / shrink; where that is far from `side`, which noise has tilted, over
/// those on its own side, and may then be across `side` (slim/normals/notes/0008). Where the normals
/// disagree (|sum| < 0.3 sum G), the direction of least spread of the points, signed by `side`
/// (NUMERICS 2.1). Unit; `side` itself if the ball is empty (+z if that is zero).
struct BallNormal {
    Vec3d normal;
    bool disagree = false;
};
template <class T>
BallNormal average_normal(const BallPoints<T>& points, double shrink, const Vec3d& side);

/// Cosine to the ball's normal below which a point's normal leaves the height field (DESIGN 4,
/// lesson 2).
inline constexpr float kLeastCos = 0.3f;
/// Cosine below which a point faces the other way: another sheet's, whatever its place.
inline constexpr float kOtherSideCos = -0.3f;

/// A point taken out of a fit because of its normal.
template <class T>
struct SetAside {
    std::size_t index;  ///< in the ball's arrays
    T sq;               ///< its squared distance, which the ball holds no more
};

/// Takes the points whose normal is below kLeastCos out of what follows (weight zero) and lists
/// them. Points without a normal stay.
template <class T>
void set_contrary_aside(BallPoints<T>& points, const Vec3d& normal, std::vector<SetAside<T>>& out);

}  // namespace slim
