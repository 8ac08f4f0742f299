#pragma once

#include "raytrace/lines/feature_line.h"
#include "raytrace/renderer.h"
#include "raytrace/shade.h"
#include "raytrace/svg_scale.h"

#include <span>
#include <string>

namespace slim {

/// The lines as an SVG 1.1 drawing, in millimetres by the scale. A group for each kind wanted, empty
/// or not (<g id="crest-ridge">: contour, suggestive, crest-ridge, crest-valley, parabolic,
/// reflection), a path for each line, its width by its strength. Their ink stands out from the
/// background; on a dark one, which is drawn under them (id="background"), else on nothing. Of a
/// part of the picture the drawing shows that window, in millimetres of the whole.
std::string lines_svg(std::span<const FeatureLine> lines, std::span<const LineKind> kinds,
                      int width, int height, const PixelWindow& window,
                      const Background& background = {}, const SvgScale& scale = SvgScale());

}  // namespace slim
