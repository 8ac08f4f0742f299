#pragma once

#include "slim/shapes/shape.h"

#include <optional>

namespace slim {

/// origin + t * direction, the direction of length one.
struct Ray {
    Vec3d origin, direction;
    Vec3d at(double t) const { return origin + direction * t; }
};

struct Interval {
    double begin = 0, end = 0;
    bool empty() const { return !(begin < end); }
};

/// The part of the ray (t >= 0) inside a box or a ball.
Interval clip_to_box(const Ray& ray, const Bbox& box);
/// The part of the ray where the surface may be: in the bounds of an open shape, which cut it off,
/// and a little beyond those of a closed one, whose flat faces may lie in the bounds.
Interval clip_to_shape(const Ray& ray, const Shape& shape);
Interval clip_to_ball(const Ray& ray, const Vec3d& center, double radius);

struct Crossing {
    double t = 0;
    bool entering = false;  ///< from outside (f > 0) to inside
};

/// First sign change of f along the ray within the interval, to about 1e-14 in t (relative).
///
/// Marches in steps that the shape's Lipschitz bound proves safe, at least 2e-4 of the diagonal (so
/// a grazing chord shorter than that may be passed over), then secants (Illinois) and bisection.
std::optional<Crossing> next_crossing(const Shape& shape, const Ray& ray, const Interval& part);

/// Largest t in the interval such that no point of the cone around the ray (radius `slope` * t) up
/// to there meets the surface; part.end if none does. For a start outside the surface.
double cone_clearance(const Shape& shape, const Ray& ray, const Interval& part, double slope);

}  // namespace slim
