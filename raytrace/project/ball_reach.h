#pragma once

#include "raytrace/camera.h"
#include "raytrace/project/outline.h"
#include "raytrace/project/screen_rect.h"

#include <algorithm>
#include <cmath>

namespace slim {

/// Where the pixels of a ball lie: in a disc about its centre, in pixel coordinates of the picture.
struct BallDisc {
    float x, y;
    /// For a ball of 1; one pixel more. A ball m off the axis (tangent) is an ellipse whose far end
    /// is (m kappa + sqrt(1 + m^2 - kappa^2)) / (1 - kappa^2) of its radius at the centre's depth
    /// away.
    float reach;

    /// share: of the support radius. Not of general surfels. kappa: as in PixelRecord
    BallDisc(const PixelView& view, const Footprint& f, float kappa, float share = 1)
        : x(f.pixel_x - f.base_x / f.step), y(f.pixel_y - f.base_y / f.step) {
        const float radius_px = share / f.step;
        reach = radius_px + 1;
        if (view.orthographic) return;
        const auto per_focal = static_cast<float>(1 / view.focal_px);
        const float u = (x - static_cast<float>(view.center_x)) * per_focal,
                    v = (y - static_cast<float>(view.center_y)) * per_focal;
        const float sq_slope = u * u + v * v, k = share * kappa, sq_k = k * k;
        reach = radius_px * (std::sqrt(sq_slope) * k + std::sqrt(1 + sq_slope - sq_k)) /
                    (1 - sq_k) + 1;
    }
};

/// The pixels of the window in a disc, and those of a rectangle in it.
inline ScreenRect joined(const BallDisc& disc, const ScreenRect& r, const PixelWindow& window) {
    const auto bound = [](float at, int least, int most) {
        return static_cast<int>(
            std::clamp(at, static_cast<float>(least), static_cast<float>(most)));
    };
    const int x1 = window.x + window.width, y1 = window.y + window.height;
    return {std::min(r.x0, bound(disc.x - disc.reach, window.x, x1)),
            std::min(r.y0, bound(disc.y - disc.reach, window.y, y1)),
            std::max(r.x1, bound(disc.x + disc.reach + 1, window.x, x1)),
            std::max(r.y1, bound(disc.y + disc.reach + 1, window.y, y1))};
}

}  // namespace slim
