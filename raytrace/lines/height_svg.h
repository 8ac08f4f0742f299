#pragma once

#include "raytrace/height_label.h"
#include "raytrace/lines/height_line.h"
#include "raytrace/renderer.h"
#include "raytrace/svg_scale.h"

#include <span>
#include <string>

namespace slim {

/// Contour lines as an SVG 1.1 drawing in millimetres of the whole picture, by the scale, that
/// shows the window. Groups: contour-lines, index-contours (wider, with gaps for their
/// heights) and contour-heights, the heights as text turned along the lines. Lines are thinned to
/// within a sixth of a pixel; pieces shorter than four widths are left out.
///
/// index_every  each so many levels is an index contour
/// line_width   of contour lines, pixels
std::string height_svg(std::span<const HeightLine> lines, std::span<const HeightLabel> labels,
                       int index_every, float line_width, const PixelWindow& window,
                       const SvgScale& scale = SvgScale());

}  // namespace slim
