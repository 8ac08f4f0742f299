#pragma once

#include "raytrace/canvas.h"
#include "slim/base/vec.h"

#include <string>
#include <string_view>

namespace slim {

/// A stroke font of our own: letters, digits and signs as lines and arcs, drawn with round pens and
/// smooth edges at any size. It is compiled in, so that a picture never depends on a font file
/// being found at run time (OpenImageIO's render_text does, CONVENTIONS 4.5).
///
/// Text is UTF-8: ASCII, the letters of Latin-1 (but eth and thorn), and U+2212 (minus), degree,
/// plus-minus, squared, cubed, micro, middle dot, times. A character without a glyph is drawn as an
/// empty box.
struct TextStyle {
    float cap_height = 14;      ///< height of capitals and digits, pixels
    Vec3f color{0, 0, 0};       ///< linear Rec.709
    float weight = 0.125f;      ///< pen width as a share of the cap height
    float opacity = 1;          ///< of turned text
};

/// The characters of a text that have no glyph, as UTF-8; a byte that fits nothing as U+FFFD.
std::string without_glyphs(std::string_view text);

/// Width in pixels of one line of text.
float text_width(std::string_view text, const TextStyle& style);

/// Draws one line; (x, baseline) is its left end in pixels, y downwards. Parts outside the picture
/// are cut off. Cost: O(pixels under the text x strokes near them).
void draw_text(const Canvas& canvas, std::string_view text, float x, float baseline,
               const TextStyle& style);

/// Draws one line turned clockwise about the middle of its capitals, (x, y). What overlaps in it is
/// drawn once, so that a translucent pen leaves no knots.
void draw_turned_text(const Canvas& canvas, std::string_view text, float x, float y,
                      float angle_rad, const TextStyle& style);

}  // namespace slim
