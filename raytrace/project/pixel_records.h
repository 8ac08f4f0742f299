#pragma once

#include "raytrace/camera.h"
#include "raytrace/intersect/pixel_record.h"
#include "slim/model/surfel.h"

namespace slim {

/// A smooth surfel, or the first sheet of a sharp one, as a function of the pixel; `view` in doubles, floats out.
/// Cost: about 150 products for degree 2, 400 for degree 3.
template <int Degree>
void fill_pixel_record(const PixelView& view, const Surfel& surfel, PixelRecord<Degree>& out);

}  // namespace slim
