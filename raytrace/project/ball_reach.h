#pragma once

#include "raytrace/camera.h"
#include "raytrace/project/outline.h"
#include "raytrace/project/screen_rect.h"

#include <algorithm>
#include <cmath>

namespace slim {

/// How far from the pixel of its centre a ball of `share` of the support radius is seen at most, in
/// pixels, and one more: a ball m off the axis (tangent) is an ellipse whose far end is
/// (m kappa + sqrt(1 + m^2 - kappa^2)) / (1 - kappa^2) of its radius at the centre's depth away.
/// Not for general surfels. kappa: as in PixelRecord.
inline float ball_reach(const PixelView& view, const Footprint& f, float kappa, float share = 1) {
    const float radius_px = share / f.step;
    if (view.orthographic) return radius_px + 1;
    const auto per_focal = static_cast<float>(1 / view.focal_px);
    const float x = (f.pixel_x - static_cast<float>(view.center_x)) * per_focal,
                y = (f.pixel_y - static_cast<float>(view.center_y)) * per_focal;
    const float sq_slope = x * x + y * y, k = share * kappa, sq_k = k * k;
    const float far_end =
        (std::sqrt(sq_slope) * k + std::sqrt(1 + sq_slope - sq_k)) / (1 - sq_k);
    return far_end * radius_px + 1;
}

/// The pixels of the window in a ball's reach.
inline ScreenRect ball_rect(const PixelView& view, const PixelWindow& window, const Footprint& f,
                            float kappa) {
    const auto reach = static_cast<int>(std::ceil(ball_reach(view, f, kappa)));
    const auto x = static_cast<int>(f.pixel_x), y = static_cast<int>(f.pixel_y);
    return {std::max(x - reach, window.x), std::max(y - reach, window.y),
            std::min(x + reach + 1, window.x + window.width),
            std::min(y + reach + 1, window.y + window.height)};
}

}  // namespace slim
