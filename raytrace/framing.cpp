#include "raytrace/framing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace slim {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

struct Interval {
    double least = kFar, most = -kFar;

    void add(double x) { least = std::min(least, x), most = std::max(most, x); }
    double middle() const { return 0.5 * (least + most); }
};

/// One axis of a perspective picture. A point at x stays inside if
/// -before <= (x - step) / (tan (distance + z)) <= after. Past what lies on the axis each side's
/// most at distance 0 gives the least distance that has a step for both.
class AxisFit {
public:
    AxisFit(std::span<const Vec3d> points, std::size_t axis, double tan, double before,
            double after)
        : points_(points), axis_(axis), tan_(tan), before_(before), after_(after) {
        for (const Vec3d& p : points_) {
            past_after_ = std::max(past_after_, p[axis_] - after_ * tan_ * p.z);
            past_before_ = std::max(past_before_, -p[axis_] - before_ * tan_ * p.z);
        }
    }

    double least_distance() const {
        return (past_after_ + past_before_) / (tan_ * (before_ + after_));
    }

    /// The part of the picture that the points take from a camera there.
    Interval seen(double distance, double step) const {
        constexpr double kNearest = 1e-12;  // of a point in the eye, whose x is but rounding
        const double nearest = std::max(kNearest * distance, std::numeric_limits<double>::min());
        Interval span;
        for (const Vec3d& p : points_) {
            const double depth = std::max(distance + p.z, nearest);
            span.add((p[axis_] - step) / (tan_ * depth));
        }
        return span;
    }

    /// To the middle of what is seen, from the axis, at the harmonic mean of the depths of its
    /// ends.
    double middle(double distance, double step) const {
        double least = kFar, most = -kFar, at_least = 0, at_most = 0;  // ends and their depths
        for (const Vec3d& p : points_) {
            const double depth = distance + p.z, x = (p[axis_] - step) / depth;
            if (x < least) least = x, at_least = depth;
            if (x > most) most = x, at_most = depth;
        }
        if (!(at_least > 0 && at_most > 0)) return 0;
        return 0.5 * (least + most) * 2 / (1 / at_least + 1 / at_most);
    }

    /// The step that brings them into the middle, or as near to it as the part has room: what is
    /// seen moves to the left as the camera steps to the right.
    double step(double distance) const {
        const double least = past_after_ - after_ * tan_ * distance;
        const double most = before_ * tan_ * distance - past_before_;
        const auto off = [&](double step) { return seen(distance, step).middle(); };
        constexpr double kCentred = 1e-12;
        if (least <= 0 && most >= 0 && std::abs(off(0)) < kCentred) return 0;
        double lo = least, hi = std::max(least, most), at_lo = off(lo), at_hi = off(hi);
        if (!std::isfinite(at_lo) || !std::isfinite(at_hi)) return std::clamp(0.0, lo, hi);
        if (at_lo <= 0) return lo;
        if (at_hi >= 0) return hi;
        // False position after Illinois: the end that stays counts half.
        constexpr int kMostSteps = 60;
        double at = lo;
        for (int k = 0, kept = 0; k < kMostSteps; ++k) {
            at = lo + (hi - lo) * at_lo / (at_lo - at_hi);
            const double value = off(at);
            if (std::abs(value) < kCentred) break;
            if (value > 0) {
                if (kept > 0) at_hi *= 0.5;
                lo = at, at_lo = value, kept = 1;
            } else {
                if (kept < 0) at_lo *= 0.5;
                hi = at, at_hi = value, kept = -1;
            }
        }
        return at;
    }

private:
    std::span<const Vec3d> points_;
    std::size_t axis_;
    double tan_, before_, after_;
    double past_before_ = -kFar, past_after_ = -kFar;
};

/// The distance of an eye that no point comes too near: of a wide view of something pointed the
/// nearest camera would stand at its tip.
double before_all(std::span<const Vec3d> points) {
    constexpr double kClear = 0.002;  // of their extent
    Interval x, y, z;
    for (const Vec3d& p : points) x.add(p.x), y.add(p.y), z.add(p.z);
    return kClear * std::hypot(x.most - x.least, y.most - y.least, z.most - z.least) - z.least;
}

/// The step of a parallel view.
double parallel_step(const Interval& x, double half, double before, double after) {
    return std::max(x.most - after * half, std::min(x.middle(), x.least + before * half));
}

}  // namespace

FrameFit fit_perspective(std::span<const Vec3d> points, double tan_x, double tan_y,
                         const FreePart& part) {
    const AxisFit x(points, 0, tan_x, part.left, part.right),
        y(points, 1, tan_y, part.top, part.bottom);
    FrameFit fit;
    fit.distance = std::max({x.least_distance(), y.least_distance(), before_all(points)});
    fit.step_right = x.step(fit.distance), fit.step_down = y.step(fit.distance);
    fit.middle_right = x.middle(fit.distance, fit.step_right);
    fit.middle_down = y.middle(fit.distance, fit.step_down);
    return fit;
}

FrameFit fit_orthographic(std::span<const Vec3d> points, double aspect, const FreePart& part) {
    Interval x, y, z;
    for (const Vec3d& p : points) x.add(p.x), y.add(p.y), z.add(p.z);
    FrameFit fit;
    fit.half_width = std::max((x.most - x.least) / (part.left + part.right),
                              (y.most - y.least) * aspect / (part.top + part.bottom));
    fit.distance = -z.least;
    if (!(fit.half_width > 0)) return fit;
    const double half_height = fit.half_width / aspect;
    fit.step_right = parallel_step(x, fit.half_width, part.left, part.right);
    fit.step_down = parallel_step(y, half_height, part.top, part.bottom);
    fit.middle_right = x.middle() - fit.step_right;
    fit.middle_down = y.middle() - fit.step_down;
    return fit;
}

}  // namespace slim
