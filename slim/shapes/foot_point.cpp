#include "slim/shapes/foot_point.h"

#include <cmath>
#include <optional>

namespace slim {
namespace {

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

/// Newton on the Lagrange conditions of min |y - x|^2 with f(y) = 0.
std::optional<Vec3d> newton_foot(const Shape& shape, const Vec3d& x) {
    const double scale = shape.bounds.diagonal();
    Jet2 f = shape.jet(x);
    Vec3d g = f.gradient();
    double lambda = f.value / sq_length(g);
    Vec3d y = x - g * lambda;
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

}  // namespace

FootPoint foot_point(const Shape& shape, const Vec3d& x) {
    const std::optional<Vec3d> newton = newton_foot(shape, x);
    const Vec3d y = newton ? *newton : gradient_projection(shape, x);
    return {y, std::copysign(length(x - y), shape.value(x)), newton.has_value()};
}

double signed_distance(const Shape& shape, const Vec3d& x) {
    return foot_point(shape, x).signed_distance;
}

}  // namespace slim
