#pragma once

#include "slim/base/vec.h"
#include "slim/neighbors/nearest.h"

#include <cstdint>
#include <span>

namespace slim {

/// How far the normals of some neighbours stray from a common linear course over their tangent
/// plane: variance of one of the two tangential components (radians^2), unbiased; curvature is no
/// noise. At least 1e-14, the rounding of a float.
/// points: indices, more than three; plane_normal: unit, of the plane that lies along them
double normal_variance_of(std::span<const Vec3d> positions, std::span<const Vec3f> normals,
                          std::span<const std::uint32_t> points, const Vec3d& plane_normal);

/// How independent of the points' noise the normals are: their squared difference to the normal of
/// the plane through k neighbours, over the variance that noise gives this one; the median over
/// samples, 1 for exact normals, near 0 for any that were estimated from about so many neighbours,
/// whatever they look like beside each other. The least over k = first_k, 1.4 first_k, ... 16
/// first_k, at most 1280 and a fiftieth of the points. samples: points of the search, of which the
/// first 600 serve, fewer the larger k. Cost: some 200,000 neighbours each.
double normal_independence(const NearestSearch& search, std::span<const std::uint32_t> samples,
                           std::span<const Vec3f> normals, std::size_t first_k);

/// Below it normals are taken for estimates.
inline constexpr double kIndependent = 0.7;

/// Whether a cloud's normals tell more of its shape than its positions do, so that fits should
/// follow both (notes/0007): the positions are noisy, and the normals are clearly better than any
/// that were made from neighbouring positions. Estimates of some size pass for better than they
/// are: see normal_independence. noise_variance: of a typical place, length^2; normal_variance:
/// radians^2; spacing: of the points, length
inline bool normals_inform(double noise_variance, double normal_variance, double spacing) {
    // in spacings: below it positions give slopes to 0.01 degrees
    constexpr double kLeastNoise = 0.05;
    // Variance of a height over that of a slope, in sq spacings: about 20 if a plane through 16
    // neighbours gave the slope, 16 to 108 on raw scans (gargoyle_scan, bunny_raw,
    // happy_stand_raw), 25,000 and more with exact normals.
    constexpr double kLeastAhead = 1000;
    const double sq_spacing = spacing * spacing;
    return noise_variance > kLeastNoise * kLeastNoise * sq_spacing &&
           noise_variance > kLeastAhead * sq_spacing * normal_variance;
}

}  // namespace slim
