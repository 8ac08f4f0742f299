#pragma once

#include "raytrace/lanes_of_vec.h"
#include "slim/base/simd.h"

#include <limits>

namespace slim {

inline constexpr float kFar = std::numeric_limits<float>::infinity();

/// Rays origin + t direction for t in [0, far]; |direction| = 1. `far` < 0 is a lane without a ray.
/// Scene coordinates; in PlacedRays those of a model's own frame.
struct RayPacket {
    LanesOfVec origin, direction;
    FloatV far{-1.0f};
    /// What their floats lack of the exact ray: places on it are found with them.
    LanesOfVec origin_low{Vec3f{}}, direction_low{Vec3f{}};
    /// They leave a surface, to either side, whose outward normal this is: what makes that surface
    /// there does not stop them (leaves_own).
    LanesOfVec normal{Vec3f{}};
    bool leaves_surface = false;
    /// Only hits behind these are looked for: the hits there were outvoted (is_outvoted in
    /// slim/blend).
    FloatV last_t{0.0f}, last_t_low{0.0f};
    bool looks_behind = false;

    FloatV::mask_type active() const { return far >= 0.0f; }
};

}  // namespace slim
