#pragma once

#include "slim/shapes/shape.h"

#include <limits>
#include <optional>

namespace slim {

/// Where the gradient leads to from y, always damped to half the box.
Vec3d gradient_projection(const Shape& shape, Vec3d y);

/// Whether y lies on the surface, to 1e-10 of the diagonal.
bool is_on(const Shape& shape, const Vec3d& y);

/// Newton on the Lagrange conditions of min |y - x|^2 with f(y) = 0, started at y with the factor
/// `lambda` of the gradient; nothing if it does not converge in 12 steps.
std::optional<Vec3d> newton_foot(const Shape& shape, const Vec3d& x, Vec3d y, double lambda);

/// The nearest to x of the points of the surface that were found.
class NearestFound {
public:
    NearestFound(const Shape& shape, const Vec3d& x)
        : shape_(shape), x_(x), tiny_(1e-12 * shape.bounds.diagonal()) {}

    /// What lies as near as what there is does not replace it.
    void add(const Vec3d& y, bool stationary);
    /// A point of the surface (others count only if there is none), and where Newton's method leads
    /// from it.
    void add_from(const Vec3d& y);

    const Vec3d& point() const { return point_; }
    double distance() const { return distance_; }  ///< infinite as long as there is none
    bool is_stationary() const { return stationary_; }

private:
    static constexpr double kNone = std::numeric_limits<double>::infinity();
    bool is_nearer(const Vec3d& y) const { return length(x_ - y) < distance_ * (1 - 1e-9) - tiny_; }

    const Shape& shape_;
    Vec3d x_, point_;
    double tiny_, distance_ = kNone;
    bool stationary_ = false;
};

}  // namespace slim
