#include "raytrace/project/screen_rect.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

/// Bounds of x / z over a ball with z > radius (NUMERICS 7.2).
void slope_bounds(double x, double z, double radius, double& lo, double& hi) {
    const double l = std::sqrt(x * x + (z - radius) * (z + radius));
    lo = (x * l - radius * z) / (z * l + radius * x);
    hi = (x * l + radius * z) / (z * l - radius * x);
}

/// Pixel indices [first, last) whose centres lie in an interval of pixel coordinates,
/// clipped to [begin, end).
void pixel_range(double lo, double hi, int begin, int end, int& first, int& last) {
    lo = std::clamp(std::ceil(lo - 0.5 - kPixelGuard), double(begin), double(end));
    hi = std::clamp(std::floor(hi - 0.5 + kPixelGuard) + 1, double(begin), double(end));
    first = static_cast<int>(lo);
    last = static_cast<int>(hi);
}

}  // namespace

ScreenRect screen_rect(const PixelView& view, const PixelWindow& w, const Vec3d& c, double radius) {
    ScreenRect rect{w.x, w.y, w.x + w.width, w.y + w.height};
    if (c.z + radius < view.near_plane) return {};
    double lo_x, hi_x, lo_y, hi_y, scale;
    if (view.orthographic) {
        lo_x = c.x - radius, hi_x = c.x + radius, lo_y = c.y - radius, hi_y = c.y + radius;
        scale = view.px_per_unit;
    } else {
        if (c.z <= radius) return rect;
        slope_bounds(c.x, c.z, radius, lo_x, hi_x);
        slope_bounds(c.y, c.z, radius, lo_y, hi_y);
        scale = view.focal_px;
    }
    pixel_range(view.center_x + lo_x * scale, view.center_x + hi_x * scale, rect.x0, rect.x1,
                rect.x0, rect.x1);
    pixel_range(view.center_y + lo_y * scale, view.center_y + hi_y * scale, rect.y0, rect.y1,
                rect.y0, rect.y1);
    return rect;
}

}  // namespace slim
