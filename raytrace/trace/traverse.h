#pragma once

#include "raytrace/trace/bvh.h"
#include "raytrace/trace/ray_packet.h"

#include <array>
#include <cstdint>
#include <span>

namespace slim {

/// 1 / d, huge instead of infinite, so that no 0 * infinity arises in a box test.
inline FloatV box_slope(const FloatV& d) {
    constexpr float kLeast = 1e-20f;
    return 1.0f /
           select<FloatV>(stdx::abs(d) < kLeast, lanes_copysign<FloatV>(FloatV(kLeast), d), d);
}

/// What box tests need of a packet.
struct BoxRays {
    LanesOfVec origin, slope;
    std::array<bool, 3> forth;  ///< most rays run this way along the axis

    explicit BoxRays(const RayPacket& rays)
        : origin(rays.origin),
          slope(box_slope(rays.direction.x), box_slope(rays.direction.y),
                box_slope(rays.direction.z)) {
        const auto on = rays.active();
        const auto sum = [&](const FloatV& d) {
            return stdx::reduce(select<FloatV>(on, d, FloatV(0.0f))) >= 0;
        };
        forth = {sum(rays.direction.x), sum(rays.direction.y), sum(rays.direction.z)};
    }

    /// Lanes that meet a box within [0, far].
    [[gnu::always_inline]] FloatV::mask_type meets(const BoxF& box, const FloatV& far) const {
        const FloatV ax = (box.lo.x - origin.x) * slope.x, bx = (box.hi.x - origin.x) * slope.x;
        const FloatV ay = (box.lo.y - origin.y) * slope.y, by = (box.hi.y - origin.y) * slope.y;
        const FloatV az = (box.lo.z - origin.z) * slope.z, bz = (box.hi.z - origin.z) * slope.z;
        const FloatV in = stdx::max(stdx::max(stdx::min(ax, bx), stdx::min(ay, by)),
                                    stdx::max(stdx::min(az, bz), FloatV(0.0f)));
        const FloatV out = stdx::min(stdx::min(stdx::max(ax, bx), stdx::max(ay, by)),
                                     stdx::min(stdx::max(az, bz), far));
        return in <= out;
    }
};

/// Calls leaf(node) for the leaves that some ray of a packet meets before `far`, nearer ones first
/// on the whole. `leaf` may lessen `far` as it finds hits, and ends the search by making all of it
/// negative. Returns the number of nodes visited.
template <class Leaf>
[[gnu::always_inline]] inline std::uint64_t for_leaves_along(const Bvh& bvh, const RayPacket& rays,
                                                             const FloatV& far, Leaf&& leaf) {
    if (bvh.nodes.empty()) return 0;
    const BoxRays at(rays);
    std::array<std::uint32_t, kMostBvhDepth + 1> stack;
    std::size_t n = 0;
    std::uint64_t visited = 0;
    stack[n++] = 0;
    while (n > 0) {
        const BvhNode& node = bvh.nodes[stack[--n]];
        ++visited;
        if (stdx::none_of(at.meets(node.box, far))) continue;
        if (node.is_leaf()) {
            leaf(node);
            continue;
        }
        const std::uint32_t nearer = at.forth[node.axis] ? 0u : 1u;
        stack[n++] = node.first + 1 - nearer;
        stack[n++] = node.first + nearer;
    }
    return visited;
}

/// Calls leaf(node) for the leaves that hold one of some points, always in the same order.
template <class Leaf>
[[gnu::always_inline]] inline void for_leaves_around(const Bvh& bvh, std::span<const BoxF> boxes,
                                                     const LanesOfVec& p,
                                                     const FloatV::mask_type& active, Leaf&& leaf) {
    if (bvh.nodes.empty()) return;
    std::array<std::uint32_t, kMostBvhDepth + 1> stack;
    std::size_t n = 0;
    stack[n++] = 0;
    while (n > 0) {
        const std::uint32_t i = stack[--n];
        const BoxF& b = boxes[i];
        const auto inside = active && p.x >= b.lo.x && p.x <= b.hi.x && p.y >= b.lo.y &&
                            p.y <= b.hi.y && p.z >= b.lo.z && p.z <= b.hi.z;
        if (stdx::none_of(inside)) continue;
        const BvhNode& node = bvh.nodes[i];
        if (node.is_leaf()) {
            leaf(node);
            continue;
        }
        stack[n++] = node.first + 1;
        stack[n++] = node.first;
    }
}

}  // namespace slim
