#pragma once

#include "slim/base/vec.h"

#include <algorithm>
#include <cstdio>
#include <string>

namespace slim {

/// "#rrggbb" of display values in [0, 1]; what lies outside is clamped.
inline std::string hex_color(const Vec3f& srgb) {
    const auto byte = [](float v) {
        return static_cast<unsigned>(std::clamp(v, 0.0f, 1.0f) * 255 + 0.5f) & 255u;
    };
    char text[8];
    std::snprintf(text, sizeof text, "#%02x%02x%02x", byte(srgb.x), byte(srgb.y), byte(srgb.z));
    return text;
}

}  // namespace slim
