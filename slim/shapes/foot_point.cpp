#include "slim/shapes/foot_point.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace slim {
namespace {

/// How much farther than |f| / |grad f| a foot may lie without a second look.
constexpr double kExpected = 1.2;

/// Solves (I + lambda H) y = b by Cramer's rule; the matrix is symmetric.
Vec3d solve_shifted(const Jet2& f, double lambda, const Vec3d& b) {
    const Vec3d a0{1 + lambda * f.h[0], lambda * f.h[1], lambda * f.h[2]};
    const Vec3d a1{lambda * f.h[1], 1 + lambda * f.h[3], lambda * f.h[4]};
    const Vec3d a2{lambda * f.h[2], lambda * f.h[4], 1 + lambda * f.h[5]};
    const Vec3d c12 = cross(a1, a2), c20 = cross(a2, a0), c01 = cross(a0, a1);
    return (c12 * b.x + c20 * b.y + c01 * b.z) / dot(a0, c12);
}

/// Where the gradient leads to, always damped to half the box.
Vec3d gradient_projection(const Shape& shape, Vec3d y) {
    const double limit = 0.5 * shape.bounds.diagonal();
    for (int i = 0; i < 30; ++i) {
        const Jet2 f = shape.jet(y);
        const Vec3d g = f.gradient();
        Vec3d step = g * (f.value / sq_length(g));
        if (!is_finite(step)) return y;
        if (length(step) > limit) step = step * (limit / length(step));
        y -= step;
        if (length(step) < 1e-14 * limit) return y;
    }
    return y;
}

/// Newton on the Lagrange conditions of min |y - x|^2 with f(y) = 0, started at y.
std::optional<Vec3d> newton_foot(const Shape& shape, const Vec3d& x, Vec3d y, double lambda) {
    const double scale = shape.bounds.diagonal();
    Jet2 f;
    Vec3d g;
    for (int i = 0; i < 12; ++i) {
        f = shape.jet(y);
        g = f.gradient();
        const Vec3d r = x - y - g * lambda;
        if (std::abs(f.value) < 1e-13 * scale * length(g) && length(r) < 1e-12 * scale) return y;
        const Vec3d mr = solve_shifted(f, lambda, r), mg = solve_shifted(f, lambda, g);
        const double d_lambda = (dot(g, mr) + f.value) / dot(g, mg);
        const Vec3d step = mr - mg * d_lambda;
        if (!is_finite(step) || length(step) > 0.5 * scale) return std::nullopt;
        y += step;
        lambda += d_lambda;
    }
    return std::nullopt;
}

bool is_on(const Shape& shape, const Vec3d& y) {
    const Jet2 f = shape.jet(y);
    return std::abs(f.value) < 1e-10 * shape.bounds.diagonal() * length(f.gradient());
}

/// The factor of the gradient at y that leads nearest to x.
double multiplier_at(const Shape& shape, const Vec3d& x, const Vec3d& y) {
    const Vec3d g = shape.jet(y).gradient();
    return dot(x - y, g) / sq_length(g);
}

/// The nearest of the points of the surface that were found.
class Nearest {
public:
    Nearest(const Shape& shape, const Vec3d& x) : shape_(shape), x_(x), tiny_(1e-12 * shape.bounds.diagonal()) {}

    /// What lies as near as what there is replaces it only if it is stationary too.
    void add(const Vec3d& y, bool stationary) {
        const double distance = length(x_ - y), most = distance_ * (1 - 1e-9) - tiny_;
        if (!(distance < most) && distance_ < kNone) return;
        point_ = y, distance_ = distance, stationary_ = stationary;
    }
    /// A point of the surface (others count only if there is none), and where Newton's method leads from it.
    void add_from(const Vec3d& y) {
        if (distance_ < kNone && !(is_on(shape_, y) && length(x_ - y) < distance_ * (1 - 1e-9) - tiny_)) return;
        add(y, false);
        const auto newton = newton_foot(shape_, x_, y, multiplier_at(shape_, x_, y));
        if (newton && length(x_ - *newton) <= distance_ * (1 + 1e-9) + tiny_)
            point_ = *newton, distance_ = length(x_ - *newton), stationary_ = true;
    }
    const Vec3d& point() const { return point_; }
    double distance() const { return distance_; }
    bool is_stationary() const { return stationary_; }

private:
    static constexpr double kNone = std::numeric_limits<double>::infinity();
    const Shape& shape_;
    Vec3d x_, point_;
    double tiny_, distance_ = kNone;
    bool stationary_ = false;
};

/// Where a fan of rays from x first meets the surface within `reach`: the nearest such point.
std::optional<Vec3d> first_met(const Shape& shape, const Vec3d& x, double value, double reach) {
    constexpr int kRays = 96, kSteps = 24, kHalvings = 40;
    std::optional<Vec3d> met;
    for (int i = 0; i < kRays; ++i) {
        // Fibonacci's spiral: even over the sphere.
        const double z = 1 - (2 * i + 1.0) / kRays, r = std::sqrt(1 - z * z), turn = i * std::numbers::pi * (3 - std::sqrt(5.0));
        const Vec3d way{r * std::cos(turn), r * std::sin(turn), z};
        const auto is_past = [&](double t) { return shape.value(x + way * t) * value <= 0; };
        int k = 1;
        while (k <= kSteps && !is_past(reach * k / kSteps)) ++k;
        if (k > kSteps) continue;
        double lo = reach * (k - 1) / kSteps, hi = reach * k / kSteps;
        for (int h = 0; h < kHalvings; ++h) (is_past((lo + hi) / 2) ? hi : lo) = (lo + hi) / 2;
        met = x + way * hi;
        reach = hi;
    }
    return met;
}

}  // namespace

FootPoint foot_point(const Shape& shape, const Vec3d& x) {
    const Jet2 f = shape.jet(x);
    const Vec3d g = f.gradient();
    const double lambda = f.value / sq_length(g), tiny = 1e-12 * shape.bounds.diagonal();
    Nearest nearest(shape, x);
    if (const auto newton = newton_foot(shape, x, x - g * lambda, lambda)) nearest.add(*newton, true);
    nearest.add_from(gradient_projection(shape, x));
    // Farther than the value at x lets expect: past an edge, or through a thin part.
    if (nearest.distance() > kExpected * std::abs(f.value) / length(g) + tiny)
        if (const auto met = first_met(shape, x, f.value, nearest.distance())) nearest.add_from(*met);
    return {nearest.point(), std::copysign(nearest.distance(), f.value), nearest.is_stationary()};
}

double signed_distance(const Shape& shape, const Vec3d& x) {
    return foot_point(shape, x).signed_distance;
}

}  // namespace slim
