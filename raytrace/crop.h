#pragma once

#include "raytrace/frame.h"
#include "raytrace/picture.h"
#include "raytrace/renderer.h"

#include <vector>

namespace slim {

/// The window's part of what is given; the window lies inside (SLIM_CHECK). Of a whole picture it
/// is that.
Picture crop(Picture picture, const PixelWindow& window);
GBuffer crop(const GBuffer& buffer, const PixelWindow& window);
std::vector<float> crop(const std::vector<float>& plane, int width, const PixelWindow& window);

}  // namespace slim
