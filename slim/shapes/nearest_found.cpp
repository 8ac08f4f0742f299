#include "slim/shapes/nearest_found.h"

#include <algorithm>
#include <cmath>

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

/// The factor of the gradient at y that leads nearest to x.
double multiplier_at(const Shape& shape, const Vec3d& x, const Vec3d& y) {
    const Vec3d g = shape.jet(y).gradient();
    return dot(x - y, g) / sq_length(g);
}

}  // namespace

bool is_on(const Shape& shape, const Vec3d& y) {
    const Jet2 f = shape.jet(y);
    return std::abs(f.value) < 1e-10 * shape.bounds.diagonal() * length(f.gradient());
}

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

std::optional<Vec3d> newton_foot(const Shape& shape, const Vec3d& x, Vec3d y, double lambda) {
    const double scale = shape.bounds.diagonal(), tiny = 1e-12 * std::max(scale, length(x - y));
    Jet2 f;
    Vec3d g;
    for (int i = 0; i < 12; ++i) {
        f = shape.jet(y);
        g = f.gradient();
        const Vec3d r = x - y - g * lambda;
        if (std::abs(f.value) < 1e-13 * scale * length(g) && length(r) < tiny) return y;
        const Vec3d mr = solve_shifted(f, lambda, r), mg = solve_shifted(f, lambda, g);
        const double d_lambda = (dot(g, mr) + f.value) / dot(g, mg);
        const Vec3d step = mr - mg * d_lambda;
        if (!is_finite(step) || length(step) > 0.5 * scale) return std::nullopt;
        y += step;
        lambda += d_lambda;
    }
    return std::nullopt;
}

void NearestFound::add(const Vec3d& y, bool stationary) {
    if (!is_nearer(y) && distance_ < kNone) return;
    point_ = y, distance_ = length(x_ - y), stationary_ = stationary;
}

void NearestFound::add_from(const Vec3d& y) {
    if (distance_ < kNone && !(is_on(shape_, y) && is_nearer(y))) return;
    add(y, false);
    const auto newton = newton_foot(shape_, x_, y, multiplier_at(shape_, x_, y));
    if (newton && length(x_ - *newton) <= distance_ * (1 + 1e-9) + tiny_)
        point_ = *newton, distance_ = length(x_ - *newton), stationary_ = true;
}

}  // namespace slim
