#pragma once

#include "raytrace/camera.h"
#include "raytrace/intersect/pixel_record.h"
#include "slim/model/surfel.h"

namespace slim {

/// The rays of the pixels about a surfel, as in PixelRecord.
struct RayForm {
    Vec3d mu;                   ///< (X, Y, 1)
    double kappa;
    double origin_x, origin_y;  ///< pixel coordinates where s = t = 0
    double step;                ///< of s and t a pixel
};

/// `c` is the surfel's centre in camera coordinates.
RayForm ray_form(const PixelView& view, const Vec3d& c, double radius);

/// A smooth surfel, or the first sheet of a sharp one, as a function of the pixel; `view` in doubles, floats out.
/// Cost: about 150 products for degree 2, 400 for degree 3.
template <int Degree>
void fill_pixel_record(const PixelView& view, const Surfel& surfel, const RayForm& form, PixelRecord<Degree>& out);

}  // namespace slim
