#pragma once

#include "raytrace/lines/line_scene.h"

#include <span>
#include <vector>

namespace slim {

/// Averages planes over (2 r + 1)^2 pixels of the sheet around each hit, r = 3 in a picture 1000
/// pixels high and in proportion: along rows, then along columns, up to where the sheet ends
/// (one_sheet). cost  O(pixels x r), parallel over rows; the same for any number of threads A NaN
/// spoils the pixels around it.
void blur_on_sheets(const LineScene& scene, std::span<std::vector<float>> planes);

}  // namespace slim
