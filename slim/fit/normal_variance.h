#pragma once

#include "slim/base/vec.h"

#include <cstdint>
#include <span>

namespace slim {

/// How far the normals of some neighbours stray from a common linear course over their tangent plane: variance of
/// one of the two tangential components (radians^2), unbiased; curvature is no noise. At least 1e-14, the
/// rounding of a float.
/// points: indices, more than three; plane_normal: unit, of the plane that lies along them
double normal_variance_of(std::span<const Vec3d> positions, std::span<const Vec3f> normals,
                          std::span<const std::uint32_t> points, const Vec3d& plane_normal);

/// Whether a cloud's normals tell more of its shape than its positions do, so that fits should follow both
/// (notes/0007): the positions are noisy, and the normals are clearly better than any that were made from
/// neighbouring positions. Normals estimated from the cloud itself are not to be asked about.
/// noise_variance: lambda, length^2; normal_variance: radians^2; spacing: of the points, length
inline bool normals_inform(double noise_variance, double normal_variance, double spacing) {
    constexpr double kLeastNoise = 0.05;      // in spacings: below it positions give slopes to 0.01 degrees
    // Variance of a height over that of a slope, in sq spacings; about 20 if a plane through 16
    // neighbours gave the slope.
    constexpr double kLeastAhead = 100;
    const double sq_spacing = spacing * spacing;
    return noise_variance > kLeastNoise * kLeastNoise * sq_spacing &&
           noise_variance > kLeastAhead * sq_spacing * normal_variance;
}

}  // namespace slim
