#pragma once

#include "raytrace/project/pixel_records.h"
#include "raytrace/project/screen_rect.h"

namespace slim {

/// An ellipse of the screen that holds a patch, in the (s, t) of its PixelRecord (project/notes/0002):
/// s^2 + 2 (b0 + b1 t) s + c0 + 2 c1 t + c2 t^2 < 0 inside.
struct Outline {
    float b0, b1, c0, c1, c2;
    float left_t, right_t;  ///< t where it reaches farthest to either side
};

/// An outline and the pixels of the window whose centres it may hold.
struct OutlinedRect {
    Outline outline;
    ScreenRect rect;
};

/// The outline of the least ellipsoid of revolution about the patch, as seen; `normal` in camera axes. For centres farther
/// off than 4 radii.
OutlinedRect patch_outline(const PixelWindow& window, const RayForm& form, const Vec3d& normal, double support_radius,
                           const PatchBounds& patch);

}  // namespace slim
