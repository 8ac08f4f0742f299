#pragma once

#include "raytrace/picture.h"
#include "raytrace/shade.h"
#include "slim/color/color_blend.h"

#include <vector>

namespace slim {

struct RenderedFrame;

/// Some rows of a frame (positions, normals, surfel ids) in the scan's own colours, over
/// transparent.
Picture paint_colors(const ColorBlend& colors, const RenderedFrame& frame, const RowRange& rows);

/// The same of all hits, linear, as shading takes them; 0 elsewhere.
std::vector<Vec3f> scan_colors(const ColorBlend& colors, const RenderedFrame& frame);

}  // namespace slim
