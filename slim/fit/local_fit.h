#pragma once

#include "slim/base/frame.h"
#include "slim/fit/ball_points.h"
#include "slim/model/polynomial.h"

#include <cstddef>
#include <cstdint>

namespace slim {

/// Why a fit has a lower degree than asked (NUMERICS 2.4), in the order they are tried.
enum class Fallback : std::uint8_t { none, few_points, rank, steep, plane };
inline constexpr std::size_t kFallbacks = 5;
const char* fallback_name(Fallback fallback);

/// A height field fitted to one ball.
struct LocalFit {
    Polynomial<double> polynomial;  ///< in the fit's frame, coordinates divided by its radius
    int degree = 0;
    double sq_error = 0;     ///< eps^2, unbiased: weighted mean squared residual / (1 - K / n_eff), length^2
    double n_effective = 0;  ///< (sum G)^2 / sum G^2
    std::size_t n_points = 0;
    Fallback fallback = Fallback::none;
};

/// Average normal of a ball: sum G n_i over the points on the side of `side` (the centre's own normal),
/// weights at |x| / shrink. Where the normals disagree (|sum| < 0.3 sum G), the direction of least
/// spread of the points, signed by `side` (NUMERICS 2.1). Unit; `side` itself if the ball is empty.
struct BallNormal {
    Vec3d normal;
    bool disagree = false;
};
template <class T>
BallNormal average_normal(const BallPoints<T>& points, double shrink, const Vec3d& side);

/// Points within `shrink` of the centre whose normal leaves the height field: n_i . n < least_cos. Points
/// without a normal do not count.
template <class T>
std::size_t count_contrary(const BallPoints<T>& points, double shrink, const Vec3d& normal,
                           float least_cos);

/// Gives points that face away from `normal` zero weight in what follows (they are another sheet's).
template <class T>
void drop_other_side(BallPoints<T>& points, const Vec3d& normal);

/// Weighted least squares w = P(u, v) of Ohtake 2005 sec. 2 in `frame`, radius = shrink * points.radius,
/// of the asked degree (1..3) or what NUMERICS 2.4 leaves of it. Never fails: the last resort is the plane
/// through the weighted mean, or through the centre where there is no weight at all.
/// Cost: one pass over the points (two where the residual is lost to cancellation), O(K^3) for the solve.
template <class T>
LocalFit fit_ball(const BallPoints<T>& points, double shrink, const Frame<double>& frame,
                  int degree);

}  // namespace slim
