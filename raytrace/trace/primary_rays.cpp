#include "raytrace/trace/primary_rays.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

/// From which t on a ray (scene coordinates, doubles) may meet anything; negative if nowhere.
double scene_entry(const Vec3d& origin, const Vec3d& direction, double t_near) {
    constexpr double kSqRadius = 1.0001;
    const double middle = -dot(origin, direction);
    const double sq_distance = sq_length(origin + direction * middle);
    if (!(sq_distance < kSqRadius)) return -1;
    const double half = std::sqrt(kSqRadius - sq_distance);
    if (middle + half < t_near) return -1;
    return std::max(t_near, middle - half);
}

/// A vector in two floats each.
void set_exact(int lane, const Vec3d& v, LanesOfVec& high, LanesOfVec& low) {
    const Vec3f rounded = to_float(v);
    high.set(lane, rounded);
    low.set(lane, to_float(v - to_double(rounded)));
}

}  // namespace

RayPacket primary_rays(const PixelView& view, const SceneFrame& frame, const PixelBlock& block) {
    RayPacket rays;
    rays.origin = rays.direction = LanesOfVec(Vec3f{0, 0, 1});
    for (int lane = 0; lane < kLanes; ++lane) {
        if (!block.holds(lane)) continue;
        const double px = block.x_of(lane) + 0.5, py = block.y_of(lane) + 0.5;
        const Vec3d direction = view.ray_direction(px, py);
        const Vec3d origin = (view.ray_origin(px, py) - frame.middle) / frame.unit;
        const double t_near = view.near_plane / (dot(direction, view.forward) * frame.unit);
        const double t = scene_entry(origin, direction, t_near);
        if (t < 0) continue;
        set_exact(lane, origin + direction * t, rays.origin, rays.origin_low);
        set_exact(lane, direction, rays.direction, rays.direction_low);
        rays.far[static_cast<std::size_t>(lane)] = kFar;
    }
    return rays;
}

}  // namespace slim
