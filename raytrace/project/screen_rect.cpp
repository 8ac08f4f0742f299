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

}  // namespace

void pixel_range(double lo, double hi, int begin, int end, int& first, int& last) {
    constexpr double kGuard = 1e-3;
    lo = std::clamp(std::ceil(lo - 0.5 - kGuard), double(begin), double(end));
    hi = std::clamp(std::floor(hi - 0.5 + kGuard) + 1, double(begin), double(end));
    first = static_cast<int>(lo);
    last = static_cast<int>(hi);
}

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

Heading::Heading(const Vec3d& normal, const Vec3d& direction)
    : along(dot(normal, direction)), across(0), size(length(direction)) {
    across = std::sqrt(std::max(0.0, size * size - along * along));
}

double PatchBounds::support(const Heading& h, bool forth) const {
    const double sign = forth ? 1 : -1, along = sign * h.along;
    if (along * radius > high * h.size)  // the ball's own extreme is cut off
        return along * high + h.across * std::sqrt(std::max(0.0, radius * radius - high * high));
    if (along * radius < low * h.size)
        return along * low + h.across * std::sqrt(std::max(0.0, radius * radius - low * low));
    return radius * h.size;
}

PatchBounds patch_bounds(double support_radius, double share, const Polynomial<double>& p) {
    const auto& a = p.a;
    const double mean = 0.5 * (a[3] + a[5]), half = 0.5 * (a[3] - a[5]);
    const double spread = std::sqrt(half * half + 0.25 * a[4] * a[4]);
    // The largest u^2 v on the unit circle is 2 / sqrt(27).
    const double third = std::abs(a[6]) + std::abs(a[9]) + 0.385 * (std::abs(a[7]) + std::abs(a[8]));
    const double tilt = std::sqrt(a[1] * a[1] + a[2] * a[2]);
    const double either = share * (tilt + share * share * third) + 1e-4;
    const double low = a[0] - either + share * share * std::min(0.0, mean - spread);
    const double high = a[0] + either + share * share * std::max(0.0, mean + spread);
    return {share * support_radius, std::clamp(low, -share, share) * support_radius,
            std::clamp(high, -share, share) * support_radius};
}

}  // namespace slim
