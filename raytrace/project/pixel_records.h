#pragma once

#include "raytrace/camera.h"
#include "raytrace/intersect/pixel_record.h"
#include "raytrace/project/surfel_lanes.h"

#include <array>

namespace slim {

/// The rays of the pixels about some surfels, as in PixelRecord.
struct RayForm {
    Vec3D mu;                    ///< (X, Y, 1)
    DoubleV kappa;
    DoubleV origin_x, origin_y;  ///< pixel coordinates where s = t = 0
    DoubleV step;                ///< of s and t a pixel
};

RayForm ray_form(const PixelView& view, const SurfelLanes& surfels);

/// s = base_x + (x - pixel_x) step, t likewise, as in PixelRecord.
struct PixelGrid {
    FloatsOfDouble pixel_x, pixel_y, base_x, base_y, step;
    explicit PixelGrid(const RayForm& form);
};

/// Surfels as functions of the pixel, lane k to *out[k] unless that is null: doubles inside, floats
/// out. Cost: about 150 products a surfel for degree 2, 400 for degree 3.
template <int Degree>
void fill_pixel_records(const SurfelLanes& surfels, const RayForm& form, const PixelGrid& grid,
                        const std::array<PixelRecord<Degree>*, kSurfelLanes>& out);

}  // namespace slim
