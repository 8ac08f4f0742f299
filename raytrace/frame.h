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
    kThirdOrderChannel = 8192,  ///< derivatives of k1 and k2 along both
                                ///< directions; cubic models only
    kHessianChannels = kCurvatureChannel | kDirectionChannel | kThirdOrderChannel,
};
using Channels = std::uint32_t;
inline constexpr Channels kAllChannels = 16383;

/// The G-buffer: flat planes, row by row from the top left; pixel (x, y) is entry y * width + x.
/// Only the planes asked for are allocated, the others are empty. Pixels without a hit hold 0
/// everywhere.
struct GBuffer {
    int width = 0, height = 0;
    Channels channels = 0;
    std::vector<std::uint8_t> hit;              ///< 1: the surface covers the pixel's centre
    std::vector<float> depth;                   ///< camera z, model units
    std::array<std::vector<float>, 3> position; ///< frame of the job
    std::array<std::vector<float>, 3> normal;
    std::vector<float> k1, k2, mean, gauss;     ///< 1 / length (gauss: 1 /
                                                ///< length^2), convex positive
    /// t1 of k1, unit, frame of the job, sign arbitrary; t2 = N x t1.
    /// Anything tangent where k1 = k2.
    std::array<std::vector<float>, 3> direction;
    /// dk1/dt1, dk1/dt2, dk2/dt1, dk2/dt2 (e1 first, e2 last), 1 / length^2;
    /// signs go with t1 and t2.
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
        resize(new_width, new_height, wanted);
        hit.assign(n_pixels(), 0);
        for_each_plane([](auto& plane) { plane.assign(plane.size(), 0); });
    }

    /// The same for a renderer that writes every pixel of what is wanted:
    /// what the planes hold is not defined.
    void resize(int new_width, int new_height, Channels wanted) {
        width = new_width, height = new_height, channels = wanted;
        hit.resize(n_pixels());
        const auto size = [&](auto& plane, Channels channel) {
            if (has(channel)) plane.resize(n_pixels());
            else plane = {};
        };
        size(depth, kDepthChannel);
        for (auto& plane : position) size(plane, kPositionChannel);
        for (auto& plane : normal) size(plane, kNormalChannel);
        size(mean, kMeanChannel), size(gauss, kGaussChannel);
        size(k1, kK1Channel), size(k2, kK2Channel);
        for (auto& plane : direction) size(plane, kDirectionChannel);
        for (auto& plane : third) size(plane, kThirdOrderChannel);
        size(surfel_id, kSurfelIdChannel);
        size(fit_error, kFitErrorChannel);
        size(level, kLevelChannel);
        size(coverage, kCoverageChannel);
        size(count, kCountChannel);
    }

    /// Calls visit(plane) for every plane but the hits; those not wanted are empty.
    template <class Visit>
    void for_each_plane(Visit&& visit) {
        visit(depth), visit(mean), visit(gauss), visit(k1), visit(k2);
        for (auto& plane : position) visit(plane);
        for (auto& plane : normal) visit(plane);
        for (auto& plane : direction) visit(plane);
        for (auto& plane : third) visit(plane);
        visit(surfel_id), visit(fit_error), visit(level), visit(coverage), visit(count);
    }
};

}  // namespace slim
