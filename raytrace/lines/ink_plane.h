#pragma once

#include "raytrace/picture.h"
#include "raytrace/renderer.h"

#include <vector>

namespace slim {

/// How far beside a pixel, in pixels, ink_plane looks: as wide as the widest stroke, so that a line
/// along an outline is of one ink.
int ink_reach(int width, int height);

/// Where lines over a picture have what is behind it beside them and take the ink of that, which is
/// another one than over the surface. 1 where a pixel within ink_reach shows nothing else, 0 where
/// all hide it, between where they do in part. Black pixels, a shadow's, hide nothing.
///
/// drawn         what stands over transparent: the wanted window and, where the picture goes on,
///               ink_reach pixels about it at least, so that a part has the whole's values
/// inside        that window, in pixels of `drawn`
/// whole_height  with whole_width the whole picture's size
/// returns       inside.width x inside.height, row by row
/// cost          O(pixels x ink_reach^2), parallel over rows
std::vector<float> ink_plane(const Picture& drawn, const PixelWindow& inside, int whole_width,
                             int whole_height);

}  // namespace slim
