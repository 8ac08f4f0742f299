#pragma once

#include "raytrace/font.h"

#include <string_view>

namespace slim {

/// Width of a line of text in an SVG whose font is so large, in the unit of that size. A viewer
/// takes what sans-serif it has: the widest of the usual ones, DejaVu, is as wide as our own font
/// to 4 %; 10 % are added, bold takes 15 % more.
inline double svg_text_width(std::string_view text, double font_size, bool bold = false) {
    constexpr double kCapHeight = 0.73, kRoom = 1.1, kBold = 1.15;
    constexpr float kScale = 64;  // of our own font, which is measured in pixels
    const TextStyle style{.cap_height = kScale * static_cast<float>(kCapHeight)};
    return static_cast<double>(text_width(text, style) / kScale) * font_size * kRoom *
           (bold ? kBold : 1);
}

}  // namespace slim
