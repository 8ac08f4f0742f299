#pragma once

#include "raytrace/trace/blend_hits.h"
#include "raytrace/trace/ray_packet.h"

#include <array>
#include <cstdint>

namespace slim {

/// What rays cost. Counts are of lanes with a ray (rays), of packets (nodes) or of all their lanes
/// (tests).
struct TraceCounts {
    std::uint64_t rays = 0;
    std::uint64_t nodes_visited = 0;  ///< boxes tested
    std::uint64_t root_tests = 0;
    std::uint64_t distance_tests = 0;

    TraceCounts& operator+=(const TraceCounts& b);
};

/// What a packet hits: the blended surface.
struct SurfaceHits {
    FloatV t{kFar};  ///< from the rays' origins, scene units; infinite without a hit
    FloatV first_t{kFar}, first_t_low{0.0f};  ///< of q^; what its float lacks
    LanesOfVec point{Vec3f{}}, point_low{Vec3f{}};  ///< scene coordinates; what their floats lack
    LanesOfVec normal{Vec3f{}};                     ///< unit, outwards
    FloatV clearance{0.0f};  ///< a ray that leaves the surface starts this far off it
    std::array<std::uint32_t, kLanes> model{}, record{};  ///< of the surfel that set q^
    BlendLanes sums;

    FloatV::mask_type hit() const { return t < kFar; }
    /// Some lanes become those of another packet.
    void take(const FloatV::mask_type& lanes, const SurfaceHits& from, Derivatives wanted);
};

}  // namespace slim
