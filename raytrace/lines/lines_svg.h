#pragma once

#include "raytrace/lines/feature_line.h"
#include "raytrace/renderer.h"

#include <span>
#include <string>

namespace slim {

/// The lines as an SVG 1.1 drawing on nothing, in millimetres: a pixel of the picture is 25.4 / 96
/// mm, as in browsers. A group for each kind wanted, empty or not (<g id="crest-ridge">: contour,
/// suggestive, crest-ridge, crest-valley, parabolic, reflection), a path for each line, its width
/// by its strength. Of a part of the picture the drawing shows that window, in millimetres of the whole.
std::string lines_svg(std::span<const FeatureLine> lines, std::span<const LineKind> kinds, int width, int height,
                      const PixelWindow& window);

}  // namespace slim
