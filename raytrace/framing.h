#pragma once

#include "slim/base/vec.h"

#include <span>

namespace slim {

/// The part of the picture that what is framed may fill: how far from the axis to each side, 1
/// being half the picture's width or height.
struct FreePart {
    double left, right, top, bottom;

    /// A border and shares of the picture that stay free at the right and the bottom.
    FreePart(double margin, double free_right, double free_bottom)
        : left(1 - margin),
          right(1 - margin - 2 * free_right),
          top(1 - margin),
          bottom(1 - margin - 2 * free_bottom) {}
};

/// Where a camera stands that frames points.
struct FrameFit {
    /// from the eye to their origin along the view; orthographic: of the nearest
    double distance = 0;
    double half_width = 0;  ///< orthographic: half the picture
    double step_right = 0, step_down = 0;  ///< of the camera
    /// To what is seen in the middle of their part of the picture, as far away as its ends are
    /// (harmonic mean): the camera that steps there by 1 - 1 / zoom keeps the middle where it is.
    double middle_right = 0, middle_down = 0;
};

/// The nearest camera that sees all points (camera axes: right, down, along the view) in a part of
/// the picture: they are in the middle of the picture, each axis for itself, or as near as that
/// part has room. tan_x, tan_y: of half the angle of view. cost O(points)
FrameFit fit_perspective(std::span<const Vec3d> points, double tan_x, double tan_y,
                         const FreePart& part);

/// The same for a parallel view.
FrameFit fit_orthographic(std::span<const Vec3d> points, double aspect, const FreePart& part);

}  // namespace slim
