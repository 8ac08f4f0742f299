#include "slim/scanner/ray_crossing.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr double kLeastStep = 2e-4;  // of the diagonal

/// Root between a and b, f(a) and f(b) of opposite sign: regula falsi with the Illinois weight,
/// bisecting whenever three steps did not halve the bracket, and from step 20 on.
double refine(const Shape& shape, const Ray& ray, double a, double fa, double b, double fb) {
    const double tolerance = 1e-15 * (1 + std::abs(b));
    double width = std::abs(b - a);
    for (int i = 0; i < 100 && std::abs(b - a) > tolerance; ++i) {
        double t = (a * fb - b * fa) / (fb - fa);
        if (i % 4 == 3) {
            if (std::abs(b - a) > 0.5 * width) t = 0.5 * (a + b);
            width = std::abs(b - a);
        }
        if (i > 20) t = 0.5 * (a + b);  // a crease in the bracket can fool secants for long
        const double f = shape.value(ray.at(t));
        if (f == 0) return t;
        if ((f > 0) == (fb > 0)) {
            fa *= 0.5;  // the same end moved: pull the secant to the other side
        } else {
            a = b;
            fa = fb;
        }
        b = t;
        fb = f;
    }
    return b;
}

}  // namespace

Interval clip_to_box(const Ray& ray, const Bbox& box) {
    Interval part{0, 1e300};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double inverse = 1 / ray.direction[axis];
        double t0 = (box.lo[axis] - ray.origin[axis]) * inverse;
        double t1 = (box.hi[axis] - ray.origin[axis]) * inverse;
        if (t0 > t1) std::swap(t0, t1);
        // A ray in a face gives 0 * inf: NaN compares false and leaves the interval as it is.
        if (t0 > part.begin) part.begin = t0;
        if (t1 < part.end) part.end = t1;
    }
    return part;
}

Interval clip_to_shape(const Ray& ray, const Shape& shape) {
    if (shape.open) return clip_to_box(ray, shape.bounds);
    const double margin = kLeastStep * shape.bounds.diagonal();
    const Vec3d grow{margin, margin, margin};
    return clip_to_box(ray, {shape.bounds.lo - grow, shape.bounds.hi + grow});
}

Interval clip_to_ball(const Ray& ray, const Vec3d& center, double radius) {
    const Vec3d oc = ray.origin - center;
    const double b = dot(oc, ray.direction), q = b * b - sq_length(oc) + radius * radius;
    if (q <= 0) return {};
    const double root = std::sqrt(q);
    return {std::max(0.0, -b - root), -b + root};
}

std::optional<Crossing> next_crossing(const Shape& shape, const Ray& ray, const Interval& part) {
    if (part.empty()) return std::nullopt;
    const double least = kLeastStep * shape.bounds.diagonal(), inverse = 1 / shape.lipschitz;
    double t = part.begin, f = shape.value(ray.at(t));
    while (t < part.end) {
        const double step = f > 0 ? f : std::min(-f, shape.band);
        const double t_next = std::min(part.end, t + std::max(step * inverse, least));
        const double f_next = shape.value(ray.at(t_next));
        if ((f > 0) != (f_next > 0))
            return Crossing{refine(shape, ray, t, f, t_next, f_next), f > 0};
        t = t_next;
        f = f_next;
    }
    return std::nullopt;
}

double cone_clearance(const Shape& shape, const Ray& ray, const Interval& part, double slope) {
    const double inverse = 1 / shape.lipschitz;
    double t = part.begin;
    while (t < part.end) {
        const double clear = shape.value(ray.at(t)) * inverse;
        const double ahead = clear - slope * t;
        // Within the ball of radius `clear` the cone is safe up to the point where it leaves it.
        if (ahead < 0.5 * slope * t) return std::max(part.begin, t);
        t += ahead / (1 + slope);
    }
    return part.end;
}

}  // namespace slim
