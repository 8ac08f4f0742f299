#include "raytrace/camera_path.h"

#include "slim/base/angle.h"
#include "slim/base/check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace slim {
namespace {

/// What is interpolated: target 3, log distance, log tan of half the angle, log width, quaternion 4
/// (w last).
using Pose = std::array<double, 10>;

Vec3d rotated(const Vec3d& v, const Vec3d& unit_axis, double angle_rad) {
    const double c = std::cos(angle_rad), s = std::sin(angle_rad);
    return v * c + cross(unit_axis, v) * s + unit_axis * (dot(unit_axis, v) * (1 - c));
}

/// Quaternion of the rotation with these columns, by its largest component (Shepperd 1978).
std::array<double, 4> quaternion_of(const Vec3d& x, const Vec3d& y, const Vec3d& z) {
    const double trace = x.x + y.y + z.z;
    const std::array<double, 4> squares{1 + x.x - y.y - z.z, 1 - x.x + y.y - z.z,
                                        1 - x.x - y.y + z.z, 1 + trace};
    const auto largest = std::max_element(squares.begin(), squares.end()) - squares.begin();
    std::array<double, 4> q;
    switch (largest) {
        case 0:
            q = {squares[0], x.y + y.x, z.x + x.z, y.z - z.y};
            break;
        case 1:
            q = {x.y + y.x, squares[1], y.z + z.y, z.x - x.z};
            break;
        case 2:
            q = {z.x + x.z, y.z + z.y, squares[2], x.y - y.x};
            break;
        default:
            q = {y.z - z.y, z.x - x.z, x.y - y.x, squares[3]};
    }
    const double scale = 0.5 / std::sqrt(squares[static_cast<std::size_t>(largest)]);
    for (double& c : q) c *= scale;
    return q;
}

/// The rotation's second and third column.
Vec3d y_axis(const double* q) {
    return {2 * (q[0] * q[1] - q[2] * q[3]), 1 - 2 * (q[0] * q[0] + q[2] * q[2]),
            2 * (q[1] * q[2] + q[0] * q[3])};
}
Vec3d z_axis(const double* q) {
    return {2 * (q[0] * q[2] + q[1] * q[3]), 2 * (q[1] * q[2] - q[0] * q[3]),
            1 - 2 * (q[0] * q[0] + q[1] * q[1])};
}

Pose pose_of(const Camera& c) {
    const Vec3d back = normalized(c.eye - c.target), right = normalized(cross(c.up, back));
    const auto q = quaternion_of(right, cross(back, right), back);
    return {c.target.x,
            c.target.y,
            c.target.z,
            std::log(length(c.eye - c.target)),
            std::log(std::tan(radians(c.fov_y_deg) / 2)),
            std::log(c.width),
            q[0],
            q[1],
            q[2],
            q[3]};
}

Camera camera_of(const Pose& p, const Camera& like) {
    Camera c = like;
    const double norm = std::sqrt(p[6] * p[6] + p[7] * p[7] + p[8] * p[8] + p[9] * p[9]);
    const double q[4] = {p[6] / norm, p[7] / norm, p[8] / norm, p[9] / norm};
    c.target = {p[0], p[1], p[2]};
    c.eye = c.target + z_axis(q) * std::exp(p[3]);
    c.up = y_axis(q);
    c.fov_y_deg = 2 * std::atan(std::exp(p[4])) * 180 / std::numbers::pi;
    c.width = std::exp(p[5]);
    return c;
}

/// Of the two quaternions of an orientation the one nearer to the keyframe before.
void align(const Pose& before, Pose& pose) {
    double same = 0;
    for (std::size_t k = 6; k < 10; ++k) same += before[k] * pose[k];
    if (same < 0)
        for (std::size_t k = 6; k < 10; ++k) pose[k] = -pose[k];
}

}  // namespace

Camera turned(const Camera& camera, const Vec3d& center, const Vec3d& axis, double angle_deg) {
    const Vec3d unit = normalized(axis);
    Camera out = camera;
    out.eye = center + rotated(camera.eye - center, unit, radians(angle_deg));
    out.target = center + rotated(camera.target - center, unit, radians(angle_deg));
    out.up = rotated(camera.up, unit, radians(angle_deg));
    return out;
}

Camera camera_on_path(std::span<const Camera> keys, double t) {
    SLIM_CHECK(keys.size(), >=, 1u);
    std::vector<Pose> poses;
    for (const Camera& key : keys) {
        SLIM_CHECK(key.orthographic, ==, keys[0].orthographic);
        poses.push_back(pose_of(key));
        if (poses.size() > 1) align(poses[poses.size() - 2], poses.back());
    }
    const double last = static_cast<double>(keys.size() - 1), at = std::clamp(t, 0.0, last);
    const double begin = std::min(std::floor(at), std::max(0.0, last - 1)), u = at - begin;
    const auto pose = [&](double offset) -> const Pose& {
        return poses[static_cast<std::size_t>(std::clamp(begin + offset, 0.0, last))];
    };
    if (pose(0) == pose(1)) return camera_of(pose(0), keys[0]);
    // A keyframe that is given twice is held: the camera comes to rest there.
    const bool leaves_rest = begin > 0 && pose(-1) == pose(0),
               comes_to_rest = begin + 2 <= last && pose(1) == pose(2);
    Pose p;
    for (std::size_t k = 0; k < p.size(); ++k) {
        const double b = pose(0)[k], c = pose(1)[k], a = leaves_rest ? c : pose(-1)[k],
                     d = comes_to_rest ? b : pose(2)[k];
        p[k] = b + 0.5 * u * (c - a + u * (2 * a - 5 * b + 4 * c - d + u * (3 * (b - c) + d - a)));
    }
    return camera_of(p, keys[0]);
}

}  // namespace slim
