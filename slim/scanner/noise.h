#pragma once

#include "slim/base/hash.h"
#include "slim/base/vec.h"

#include <cmath>
#include <cstdint>
#include <numbers>

namespace slim {

/// What a random number of the scanner is for; part of its key.
enum class Draw : std::uint64_t { range, offset_y, offset_z, dropout, outlier, place, keep, line };

/// Uniform in [0, 1), keyed by seed, ray and purpose: the same for any thread and order.
inline double uniform_draw(std::uint64_t seed, std::uint64_t ray, Draw purpose) {
    return unit_interval(keyed_hash(seed, ray, static_cast<std::uint64_t>(purpose)));
}

/// Standard normal (Box-Muller), keyed likewise.
inline double gaussian_draw(std::uint64_t seed, std::uint64_t ray, Draw purpose) {
    const std::uint64_t h = keyed_hash(seed, ray, static_cast<std::uint64_t>(purpose));
    const double radius = std::sqrt(-2 * std::log(1 - unit_interval(h)));
    return radius * std::cos(2 * std::numbers::pi * unit_interval(mix64(h)));
}

/// Three independent standard normals.
inline Vec3d gaussian_vector(std::uint64_t seed, std::uint64_t ray) {
    return {gaussian_draw(seed, ray, Draw::range), gaussian_draw(seed, ray, Draw::offset_y),
            gaussian_draw(seed, ray, Draw::offset_z)};
}

}  // namespace slim
