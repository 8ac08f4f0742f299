#pragma once

#include "slim/base/frame.h"
#include "slim/base/hash.h"
#include "slim/model/point_block.h"

#include <cmath>
#include <cstdint>
#include <numbers>

namespace slim::test {

inline void add_point(PointBlock& block, const Vec3d& p, const Vec3d& normal) {
    block.position.push_back(p);
    block.normal.push_back(to_float(normal));
    block.id.push_back(block.id.size());
}

/// A capped rod from `from` along `axis`, its whole length; points at random by area.
inline void add_rod(PointBlock& block, const Vec3d& from, const Vec3d& axis, double radius,
                    std::size_t n, bool capped = true) {
    const Frame<double> frame = frame_from_normal(normalized(axis));
    const double caps = capped ? radius / (radius + length(axis)) : 0;  // of the area
    for (std::size_t i = 0; i < n; ++i) {
        const std::uint64_t key = block.id.size();
        const auto unit = [&](std::uint64_t k) { return unit_interval(keyed_hash(91, key, k)); };
        const double a = 2 * std::numbers::pi * unit(1);
        const Vec3d out = frame.u_axis * std::cos(a) + frame.v_axis * std::sin(a);
        if (unit(2) >= caps) {
            add_point(block, from + axis * unit(3) + out * radius, out);
            continue;
        }
        const bool at_end = unit(3) < 0.5;
        add_point(block, from + axis * (at_end ? 1.0 : 0.0) + out * (radius * std::sqrt(unit(4))),
                  frame.normal * (at_end ? 1.0 : -1.0));
    }
}

/// A torus about the z axis.
inline void add_ring(PointBlock& block, const Vec3d& center, double radius, double thickness,
                     std::size_t n) {
    for (std::size_t made = 0, tried = 0; made < n; ++tried) {
        const auto unit = [&](std::uint64_t k) {
            return unit_interval(keyed_hash(92, block.id.size() + tried, k));
        };
        const double a = 2 * std::numbers::pi * unit(1), b = 2 * std::numbers::pi * unit(2);
        if (unit(3) * (radius + thickness) > radius + thickness * std::cos(b)) continue;
        const Vec3d out{std::cos(a), std::sin(a), 0};
        const Vec3d normal = out * std::cos(b) + Vec3d{0, 0, std::sin(b)};
        add_point(block, center + out * radius + normal * thickness, normal);
        ++made;
    }
}

}  // namespace slim::test
