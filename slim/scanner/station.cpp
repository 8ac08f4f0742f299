#include "slim/scanner/station.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slim {
namespace {

/// Direction from the centre to station i of n: even steps in height, golden angle around y.
Vec3d station_direction(int i, int n) {
    const double height = 0.9 * (1 - (2.0 * i + 1) / n);
    const double golden_angle_rad = std::numbers::pi * (3 - std::sqrt(5.0));
    const double around = i * golden_angle_rad + 0.35, level = std::sqrt(1 - height * height);
    return {level * std::sin(around), height, level * std::cos(around)};
}

Frame<double> looking_along(const Vec3d& axis) {
    const Vec3d right = normalized(cross(axis, Vec3d{0, 1, 0}));
    return {right, cross(right, axis), axis};
}

void fit_frustum(Station& s, const Bbox& bounds) {
    s.u_lo = s.v_lo = 1e300;
    s.u_hi = s.v_hi = -1e300;
    for (unsigned corner = 0; corner < 8; ++corner) {
        const Vec3d p{(corner & 1 ? bounds.hi : bounds.lo).x,
                      (corner & 2 ? bounds.hi : bounds.lo).y,
                      (corner & 4 ? bounds.hi : bounds.lo).z};
        const Vec3d local = s.axes.local_from_world(p - s.position);
        s.u_lo = std::min(s.u_lo, local.x / local.z);
        s.u_hi = std::max(s.u_hi, local.x / local.z);
        s.v_lo = std::min(s.v_lo, local.y / local.z);
        s.v_hi = std::max(s.v_hi, local.y / local.z);
    }
}

}  // namespace

void Station::set_pitch(double new_pitch) {
    pitch = new_pitch;
    rows = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::ceil((v_hi - v_lo) / pitch)));
    cols = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::ceil((u_hi - u_lo) / pitch)));
}

Ray Station::ray(double row, double col) const {
    const double u = u_lo + (col + col_shift) * pitch, v = v_hi - (row + row_shift) * pitch;
    return {position, normalized(axes.world_from_local({u, v, 1}))};
}

std::vector<Station> stations_around(const Bbox& bounds, int n) {
    std::vector<Station> stations(static_cast<std::size_t>(n));
    for (int i = 0; i < n; ++i) {
        Station& s = stations[static_cast<std::size_t>(i)];
        const Vec3d away = station_direction(i, n);
        s.id = static_cast<std::uint16_t>(i);
        s.position = bounds.center() + away * (1.5 * bounds.diagonal());
        s.axes = looking_along(-away);
        fit_frustum(s, bounds);
    }
    return stations;
}

}  // namespace slim
