#pragma once

#include "raytrace/camera.h"
#include "raytrace/renderer.h"
#include "slim/model/polynomial.h"

namespace slim {

/// Pixels [x0, x1) x [y0, y1) of the whole picture.
struct ScreenRect {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    bool empty() const { return x0 >= x1 || y0 >= y1; }
};

/// Pixel indices [first, last) whose centres lie in an interval of pixel coordinates, with a guard of a
/// thousandth of a pixel, clipped to [begin, end).
void pixel_range(double lo, double hi, int begin, int end, int& first, int& last);

/// Pixels of the window whose centre's ray may meet the ball in front of the near plane: exact bounds
/// per axis for a ball in front of the eye's plane (NUMERICS 7.2), the whole window otherwise.
ScreenRect screen_rect(const PixelView& view, const PixelWindow& window, const Vec3d& center,
                       double radius);

/// A direction seen from a surfel, of any length.
struct Heading {
    double along, across;  ///< its parts along the normal and in the plane
    double size;

    Heading(const Vec3d& normal, const Vec3d& direction);
};

/// What a surfel's surface can reach: the part of a ball between two planes across its normal. A surfel is a
/// pancake, so this is much less than the ball where it is seen from the side.
struct PatchBounds {
    double radius;
    double low, high;  ///< along the normal, from the centre

    /// How far it reaches in a direction from the centre (`forth`), or against it.
    double support(const Heading& h, bool forth) const;
};

/// Of the surface w = P(u, v) of a surfel inside `share` of its ball.
PatchBounds patch_bounds(double support_radius, double share, const Polynomial<double>& p);

}  // namespace slim
