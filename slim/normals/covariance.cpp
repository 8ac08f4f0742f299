#include "slim/normals/covariance.h"

#include <Eigen/Eigenvalues>

#include <algorithm>

namespace slim {
namespace {

// of the largest: what the sums' rounding leaves of the smallest where the points are a plane
constexpr double kRounding = 1e-15;

/// The mean square of the points' distances along n from their mean.
double sq_thickness(std::span<const Vec3d> positions, std::span<const std::uint32_t> points,
                    const Vec3d& n) {
    const Vec3d first = positions[points[0]];
    double sum = 0, sq_sum = 0;
    for (const std::uint32_t i : points) {
        const double off = dot(positions[i] - first, n);
        sum += off, sq_sum += off * off;
    }
    const double inv_n = 1 / static_cast<double>(points.size());
    return std::max(sq_sum * inv_n - sum * inv_n * (sum * inv_n), 0.0);
}

}  // namespace

Spread spread_of(std::span<const Vec3d> positions, std::span<const std::uint32_t> points) {
    // Sums about the first point: its distance to the mean is of the size of the spread.
    const Vec3d first = positions[points[0]];
    Vec3d sum;
    double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
    for (const std::uint32_t i : points) {
        const Vec3d d = positions[i] - first;
        sum += d;
        xx += d.x * d.x, xy += d.x * d.y, xz += d.x * d.z;
        yy += d.y * d.y, yz += d.y * d.z, zz += d.z * d.z;
    }
    const double inv_n = 1 / static_cast<double>(points.size());
    const Vec3d mean = sum * inv_n;
    Eigen::Matrix3d c;
    c(0, 0) = xx * inv_n - mean.x * mean.x;
    c(1, 1) = yy * inv_n - mean.y * mean.y;
    c(2, 2) = zz * inv_n - mean.z * mean.z;
    c(1, 0) = c(0, 1) = xy * inv_n - mean.x * mean.y;
    c(2, 0) = c(0, 2) = xz * inv_n - mean.x * mean.z;
    c(2, 1) = c(1, 2) = yz * inv_n - mean.y * mean.z;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect(c);
    const Eigen::Vector3d n = solver.eigenvectors().col(0).normalized();
    // The trigonometric formula leaves 1e-16 of the largest in the smallest, the Rayleigh quotient
    // a tenth of that where the plane is no plane of the axes.
    const Vec3d normal{n.x(), n.y(), n.z()};
    const double largest = std::max(solver.eigenvalues()[2], 0.0);
    double smallest = std::max(n.dot(c * n), 0.0);
    if (smallest < kRounding * largest) smallest = sq_thickness(positions, points, normal);
    return {smallest, std::max(solver.eigenvalues()[1], 0.0), largest, normal};
}

double sq_reach_of(std::span<const Vec3d> positions, std::uint32_t point,
                   std::span<const std::uint32_t> neighbors) {
    double most = 0;
    for (const std::uint32_t i : neighbors)
        most = std::max(most, sq_length(positions[i] - positions[point]));
    return most;
}

}  // namespace slim
