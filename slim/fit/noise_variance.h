#pragma once

#include "slim/base/vec.h"
#include "slim/fit/variance_bins.h"
#include "slim/neighbors/nearest.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace slim {

/// lambda of Ohtake 2005 eq. (3): the mean over points of the smallest eigenvalue of the covariance
/// of their k nearest neighbours at distinct places. robust_noise() says what of it counts.
struct NoiseVariance {
    double value = 0;     ///< length^2
    double flatness = 0;  ///< mean of smallest / middle eigenvalue; above
                          ///< 0.1 the neighbourhood is no longer flat
    double spacing = 0;   ///< square root of the area that a point usually
                          ///< has: geometric mean over the samples
    /// Of the normals, one component, radians^2: geometric mean of normal_variance_of over the
    /// samples, so that edges do not count; 0 without normals.
    double normal = 0;
    double typical = 0;  ///< geometric mean in place of `value`: noise,
                         ///< where edges make up that of a clean cloud
    double line_share = 0;  ///< of the samples, whose fewest neighbours lie on a line
    double independence = 0;  ///< normal_independence, where normals_inform; else 0
    std::size_t neighbors = 10;
    std::size_t n_sampled = 0;
    VarianceBins bins;  ///< of the samples that `value` is the mean of
};

/// The numbers of neighbours tried, and the flatness at which the search among them ends.
inline constexpr std::size_t kNoiseNeighbors[] = {10, 20, 40, 80, 160, 320, 640, 1280, 2560, 5120};
/// More are wanted where noise is several spacings thick, and cost a second a slice.
inline constexpr std::size_t kUsualMostNeighbors = 160;
inline constexpr double kFlat = 0.1;
/// Samples that every mean is over, if there are so many.
inline constexpr std::size_t kFewestSamples = 1000;

/// With k = `neighbors`; 0: the first of kNoiseNeighbors whose robust flatness is at most 0.1
/// (NUMERICS 3.2), or the flattest: noise asks for more neighbours, edges and curvature for fewer.
/// Points with fewer than three distinct neighbours are left out; none left gives value 0. samples:
/// points of the search by falling priority, of which the first serve where fewer do; those that
/// lie at one place count once. normals: of the search's points; empty: none. fewest: samples, if
/// there are so many; of one slice of many fewer will do. Cost: one k-NN query a sample, fewer the
/// larger k.
NoiseVariance estimate_noise_variance(const NearestSearch& search,
                                      std::span<const std::uint32_t> samples, std::size_t neighbors,
                                      std::span<const Vec3f> normals = {},
                                      std::size_t fewest = kFewestSamples);

/// What counts of a whole cloud's.
struct RobustNoise {
    double variance = 0;  ///< lambda
    double flatness = 0;
};

/// Share of the samples that no surface of the usual spacing explains and that are far beyond the
/// median: strays, but for those near a surface.
double stray_share(const NoiseVariance& noise);

/// `value` and `flatness`, unless few of the samples make most of them (notes/0016). Samples that
/// no surface of the usual spacing explains and that are far beyond nearly all others are strays
/// and left out. Noise of a part, more than edges show and not in the median, adds to lambda what
/// bends and edges would, and to flatness nothing. The same where neither is so.
RobustNoise robust_noise(const NoiseVariance& noise);

}  // namespace slim
