#pragma once

#include "slim/fit/ball_points.h"
#include "slim/fit/sharp_fit.h"

namespace slim {

/// Whether the points bear out the joined surface in the core (kTrim of the ball; notes/0002 and
/// 0013): wherever it runs
/// - a point lies within max(0.25 rho, 2.5 spacings) that faces its way, else a sheet is extended
/// into the air,
///   where it would stand as a spike or a fin;
/// - at an edge or a corner of one kind, it stands out of no plane of the points near it (1.2
/// spacings): where a
///   face curves away or a third one bounds the edge, sheets that go straight on would stand out as
///   splinters. All that a convex edge's faces are lies below the planes of all its points, a
///   concave edge's above them.
/// noise_variance  of the points, length^2: of a typical place, not what edges add to lambda
/// cost            up to 121 places a sheet against all points
template <class T>
bool is_filled(const SharpFit& fit, const BallPoints<T>& points, double noise_variance);

}  // namespace slim
