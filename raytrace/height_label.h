#pragma once

#include "raytrace/canvas.h"
#include "slim/base/vec.h"

#include <span>
#include <string>
#include <vector>

namespace slim {

inline constexpr Vec3f kContourInk{0.16f, 0.07f, 0.025f};  ///< brown, linear Rec.709

/// The height of an index contour, written along the line, which has a gap for it.
struct HeightLabel {
    std::string text;          ///< UTF-8
    float x = 0, y = 0;        ///< its middle, pixels of the whole picture
    float angle_rad = 0;       ///< from the picture's right, clockwise; the text's head is uphill
    float width = 0;           ///< of the text, pixels
    float cap_height = 0;      ///< pixels

    /// Half of the gap along the line and across it, pixels.
    float half_length() const { return 0.5f * width + 0.45f * cap_height; }
    float half_height() const { return 0.85f * cap_height; }
};

/// How much of a contour line is seen at a place of the picture: 0 in the label's gap, 1 beyond,
/// with an edge a pixel wide.
float seen_beside(const HeightLabel& label, float x, float y);

/// Those whose gaps reach into a row of the picture (pixels, its middle).
std::vector<const HeightLabel*> labels_near(std::span<const HeightLabel> labels, float y);

/// Writes the heights, in the colour of the lines, over a light edge that keeps them legible on the
/// shaded side.
void draw_height_labels(std::span<const HeightLabel> labels, const Canvas& canvas);

}  // namespace slim
