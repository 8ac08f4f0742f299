#pragma once

#include "raytrace/camera.h"
#include "raytrace/renderer.h"

namespace slim {

/// Pixels [x0, x1) x [y0, y1) of the whole picture.
struct ScreenRect {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    bool empty() const { return x0 >= x1 || y0 >= y1; }
};

/// Pixels whose centre lies no farther outside of what is bounded than this belong to it.
inline constexpr double kPixelGuard = 1e-3;

/// Pixels of the window whose centre's ray may meet the ball in front of the near plane: exact
/// bounds per axis for a ball in front of the eye's plane (NUMERICS 7.2),
/// the whole window otherwise.
ScreenRect screen_rect(const PixelView& view, const PixelWindow& window, const Vec3d& center,
                       double radius);

}  // namespace slim
