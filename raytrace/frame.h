#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace slim {

/// What a renderer is asked for: a set of bits. The hit mask is always there.
enum Channel : std::uint32_t {
    kDepthChannel = 1,      ///< camera z
    kPositionChannel = 2,   ///< P, frame of the job
    kNormalChannel = 4,     ///< N, unit, outwards, world axes
    kMeanChannel = 8,
    kSurfelIdChannel = 16,  ///< node of the surfel that set the first hit
    kFitErrorChannel = 32,  ///< its eps, model units
    kLevelChannel = 64,     ///< its level
    kCoverageChannel = 128, ///< sum of the weights G
    kCountChannel = 256,    ///< number of surfels blended
    kGaussChannel = 512,
    kK1Channel = 1024,
    kK2Channel = 2048,
    kCurvatureChannel = kMeanChannel | kGaussChannel | kK1Channel | kK2Channel,
    kDirectionChannel = 4096,   ///< principal direction of k1
    kThirdOrderChannel = 8192,  ///< derivatives of k1 and k2 along both directions; cubic models only
    kHessianChannels = kCurvatureChannel | kDirectionChannel | kThirdOrderChannel,
};
using Channels = std::uint32_t;
inline constexpr Channels kAllChannels = 16383;

/// The G-buffer: flat planes, row by row from the top left; pixel (x, y) is entry y * width + x. Only
/// the planes asked for are allocated, the others are empty. Pixels without a hit hold 0 everywhere.
struct GBuffer {
    int width = 0, height = 0;
    Channels channels = 0;
    std::vector<std::uint8_t> hit;              ///< 1: the surface covers the pixel's centre
    std::vector<float> depth;                   ///< camera z, model units
    std::array<std::vector<float>, 3> position; ///< frame of the job
    std::array<std::vector<float>, 3> normal;
    std::vector<float> k1, k2, mean, gauss;     ///< 1 / length (gauss: 1 / length^2), convex positive
    /// t1 of k1, unit, frame of the job, sign arbitrary; t2 = N x t1. Anything tangent where k1 = k2.
    std::array<std::vector<float>, 3> direction;
    /// dk1/dt1, dk1/dt2, dk2/dt1, dk2/dt2 (e1 first, e2 last), 1 / length^2; signs go with t1 and t2.
    std::array<std::vector<float>, 4> third;
    std::vector<std::uint32_t> surfel_id;
    std::vector<float> fit_error, level, coverage;
    std::vector<std::uint32_t> count;

    std::size_t n_pixels() const {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    }
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x);
    }
    bool has(Channels wanted) const { return (channels & wanted) == wanted; }
    bool has_any(Channels wanted) const { return (channels & wanted) != 0; }

    /// All pixels without a hit; keeps the memory of a buffer of the same size and channels.
    void reset(int new_width, int new_height, Channels wanted) {
        width = new_width, height = new_height, channels = wanted;
        hit.assign(n_pixels(), 0);
        clear(depth, kDepthChannel);
        for (auto& plane : position) clear(plane, kPositionChannel);
        for (auto& plane : normal) clear(plane, kNormalChannel);
        clear(mean, kMeanChannel), clear(gauss, kGaussChannel);
        clear(k1, kK1Channel), clear(k2, kK2Channel);
        for (auto& plane : direction) clear(plane, kDirectionChannel);
        for (auto& plane : third) clear(plane, kThirdOrderChannel);
        clear(surfel_id, kSurfelIdChannel);
        clear(fit_error, kFitErrorChannel);
        clear(level, kLevelChannel);
        clear(coverage, kCoverageChannel);
        clear(count, kCountChannel);
    }

private:
    template <class T>
    void clear(std::vector<T>& plane, Channels channel) const {
        if (has(channel)) plane.assign(n_pixels(), T(0));
        else plane = {};
    }
};

}  // namespace slim
