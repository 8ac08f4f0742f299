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
class BoxRays {
public:
    explicit BoxRays(const RayPacket& rays)
        : slope_(box_slope(rays.direction.x), box_slope(rays.direction.y),
                 box_slope(rays.direction.z)),
          at_zero_(-rays.origin.x * slope_.x, -rays.origin.y * slope_.y,
                   -rays.origin.z * slope_.z) {
        const auto on = rays.active();
        const int n = stdx::popcount(on);
        const std::array<const FloatV*, 3> slopes{&slope_.x, &slope_.y, &slope_.z};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const int n_forth = stdx::popcount(on && *slopes[axis] > 0.0f);
            together_ = together_ && (n_forth == 0 || n_forth == n);
            forth_[axis] = 2 * n_forth >= n;
            near_[axis] = forth_[axis] ? axis : axis + 3;
            far_[axis] = forth_[axis] ? axis + 3 : axis;
        }
    }

    /// Whether most rays run towards higher coordinates.
    bool runs_forth(std::size_t axis) const { return forth_[axis]; }

    /// Lanes that meet a box within [0, far]. Off by the rounding of the rays' origins, for which
    /// boxes have a margin.
    [[gnu::always_inline]] FloatV::mask_type meets(const BoxF& box, const FloatV& far) const {
        const FloatV none(0.0f);
        // Rays that run the same way meet the same planes first.
        if (together_)
            return stdx::max(stdx::max(at_x(box, near_[0]), at_y(box, near_[1])),
                             stdx::max(at_z(box, near_[2]), none)) <=
                   stdx::min(stdx::min(at_x(box, far_[0]), at_y(box, far_[1])),
                             stdx::min(at_z(box, far_[2]), far));
        const FloatV ax = at_x(box, 0), bx = at_x(box, 3);
        const FloatV ay = at_y(box, 1), by = at_y(box, 4);
        const FloatV az = at_z(box, 2), bz = at_z(box, 5);
        const FloatV in = stdx::max(stdx::max(stdx::min(ax, bx), stdx::min(ay, by)),
                                    stdx::max(stdx::min(az, bz), none));
        const FloatV out = stdx::min(stdx::min(stdx::max(ax, bx), stdx::max(ay, by)),
                                     stdx::min(stdx::max(az, bz), far));
        return in <= out;
    }

private:
    /// Where the rays meet a plane of a box: 0 to 2 are its low ones, 3 to 5 its high ones.
    [[gnu::always_inline]] FloatV at_x(const BoxF& box, std::size_t plane) const {
        return lanes_fma<FloatV>(FloatV(box.planes()[plane]), slope_.x, at_zero_.x);
    }
    [[gnu::always_inline]] FloatV at_y(const BoxF& box, std::size_t plane) const {
        return lanes_fma<FloatV>(FloatV(box.planes()[plane]), slope_.y, at_zero_.y);
    }
    [[gnu::always_inline]] FloatV at_z(const BoxF& box, std::size_t plane) const {
        return lanes_fma<FloatV>(FloatV(box.planes()[plane]), slope_.z, at_zero_.z);
    }

    LanesOfVec slope_, at_zero_;  ///< a plane at c is met at c slope + at_zero
    std::array<bool, 3> forth_;
    std::array<std::size_t, 3> near_, far_;  ///< planes that most rays meet first and last
    bool together_ = true;                   ///< all rays run the way that most do
};

/// Calls leaf(node) for the leaves that some ray of a packet meets before `far`, nearer ones first
/// on the whole. `leaf` may lessen `far` as it finds hits, and ends the search by making all of it
/// negative. Returns the number of boxes tested.
template <class Leaf>
[[gnu::always_inline]] inline std::uint64_t for_leaves_along(const Bvh& bvh, const RayPacket& rays,
                                                             const FloatV& far, Leaf&& leaf) {
    if (bvh.nodes.empty()) return 0;
    const BoxRays at(rays);
    std::uint64_t tested = 0;
    const auto meets = [&](std::uint32_t i) __attribute__((always_inline)) {
        ++tested;
        return stdx::any_of(at.meets(bvh.nodes[i].box, far));
    };
    std::array<std::uint32_t, kMostBvhDepth + 1> stack;
    std::size_t n = 0;
    stack[n++] = 0;
    while (n > 0) {
        std::uint32_t i = stack[--n];
        // Hits since it was put off may have come before it.
        bool met = meets(i);
        while (met && !bvh.nodes[i].is_leaf()) {
            const BvhNode& node = bvh.nodes[i];
            const std::uint32_t nearer = at.runs_forth(node.axis) ? 0u : 1u;
            const std::uint32_t first = node.first + nearer, second = node.first + 1 - nearer;
            const bool meets_first = meets(first), meets_second = meets(second);
            if (meets_first && meets_second) stack[n++] = second;
            met = meets_first || meets_second;
            i = meets_first ? first : second;
        }
        if (!met) continue;
        leaf(bvh.nodes[i]);
        if (stdx::none_of(far >= 0.0f)) break;
    }
    return tested;
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
