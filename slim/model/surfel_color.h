#pragma once

#include "slim/base/vec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace slim {

/// Colour of a surfel as a linear function of its local coordinates (u, v) over rho: base + du u +
/// dv v, display-referred sRGB, 0 to 1.
struct SurfelColor {
    Vec3f base, du, dv;

    Vec3f at(float u, float v) const {
        const Vec3f c = base + du * u + dv * v;
        return {std::clamp(c.x, 0.0f, 1.0f), std::clamp(c.y, 0.0f, 1.0f),
                std::clamp(c.z, 0.0f, 1.0f)};
    }
};

/// As it stands in the file: 18 bytes a surfel, steps of 1/8192, from -4 to 4.
using PackedColor = std::array<std::int16_t, 9>;

inline PackedColor pack(const SurfelColor& color) {
    PackedColor out;
    const Vec3f* const parts[] = {&color.base, &color.du, &color.dv};
    for (std::size_t k = 0; k < 9; ++k)
        out[k] = static_cast<std::int16_t>(
            std::lround(std::clamp((*parts[k / 3])[k % 3] * 8192, -32767.0f, 32767.0f)));
    return out;
}

inline SurfelColor unpack(const PackedColor& packed) {
    const auto vec = [&](std::size_t k) {
        return Vec3f{static_cast<float>(packed[k]), static_cast<float>(packed[k + 1]),
                     static_cast<float>(packed[k + 2])} *
               (1.0f / 8192);
    };
    return {vec(0), vec(3), vec(6)};
}

}  // namespace slim
