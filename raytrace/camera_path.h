#pragma once

#include "raytrace/camera.h"

#include <span>

namespace slim {

/// The camera carried about an axis through a point, by the right-hand rule.
Camera turned(const Camera& camera, const Vec3d& center, const Vec3d& axis, double angle_deg);

/// A camera on a smooth path through keyframes, which it passes at t = 0, 1, ..., n - 1 (t is
/// clamped): Catmull-Rom splines of the target, the logarithms of distance, opening and width, and
/// the orientation (normalised quaternions). Keyframes in a row that are equal are held: the camera
/// rests between them. At least one keyframe; all orthographic or all perspective (SLIM_CHECK).
Camera camera_on_path(std::span<const Camera> keys, double t);

}  // namespace slim
