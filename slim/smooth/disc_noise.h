#pragma once

#include "slim/smooth/wide_fit.h"

#include <optional>
#include <span>

namespace slim {

/// Noise over a disc.
struct DiscNoise {
    double sq = 0;  ///< squared
    /// All that was asked, the normals too, agrees within 2.5 times: there is no edge, it is noise.
    bool plain = false;
};

/// Squared noise of the heights of points over a small disc, whatever the surface's shape there:
/// how far points are off the planes through the six nearest to them, by feet in the frame's plane,
/// over what that is for unit noise (pseudo-residuals: Gasser, Sroka, Jennen-Steinmetz 1986); the
/// median, so that points beside an edge do not count. Six that lie nearly on a line, as of scan
/// lines far apart, make a line. The least of the quartic's residual over the disc (unless points
/// lie on lines), of the heights' pseudo-residuals and of those of the heights less the disc's
/// quadratic.
/// n_points  within `radius` of the centre, about
/// noise     no narrower a disc than four of it: thick noise is cut off by a ball
/// by_normals  the least also of how far points are off the arcs to their nearest, by the normals
///             of both: where all is edge
/// Nothing where there are too few points to fit. Cost: a fit, and some 50 searches among its
/// points.
std::optional<DiscNoise> disc_noise(const PointTree& points, const Vec3d& center,
                                    const Frame<double>& frame, double radius, double n_points,
                                    double noise, bool by_normals, WideWork& work);

/// Median of squares of pseudo-residuals over that of a unit normal's square; nothing of fewer than
/// 12 points. u, v, height: of each point, any one unit
std::optional<double> pseudo_residual_noise(std::span<const double> u, std::span<const double> v,
                                            std::span<const double> height);

}  // namespace slim
