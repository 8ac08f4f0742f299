#pragma once

namespace slim {

/// One glyph: the pen's path on a grid where capitals are 14 high, small letters 10, the baseline
/// at 0 and y upwards. M x y moves the pen, L x y draws a line, A cx cy rx ry a0 a1 an elliptic arc
/// from angle a0 to a1 (degrees, counter-clockwise positive),
/// joined to the path before it by a line.
struct Glyph {
    char32_t code;
    float advance;  ///< width without the gap to the next glyph
    const char* path;
    const char* mark = "";  ///< an accent's path, drawn with its origin at (mark_x, mark_y)
    float mark_x = 0, mark_y = 0;
};

/// The glyph of a character, or an empty box.
Glyph glyph_of(char32_t code);

}  // namespace slim
