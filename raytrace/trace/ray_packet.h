#pragma once

#include "raytrace/lanes_of_vec.h"
#include "slim/base/simd.h"

#include <limits>

namespace slim {

inline constexpr float kFar = std::numeric_limits<float>::infinity();

/// Rays origin + t direction for t in [0, far]; |direction| = 1. `far` < 0 is a lane without a ray.
/// Scene coordinates, but those of a model's own frame in PlacedRays.
struct RayPacket {
    LanesOfVec origin, direction;
    FloatV far{-1.0f};
    /// What their floats lack of the exact ray: places on it are found with them.
    LanesOfVec origin_low{Vec3f{}}, direction_low{Vec3f{}};
    /// They leave a surface whose outward normal this is, on either side: what makes that surface
    /// there does not stop them (leaves_own).
    LanesOfVec normal{Vec3f{}};
    bool leaves_surface = false;
    /// Only first hits behind these are looked for: those there were outvoted (BlendSums).
    FloatV last_t{0.0f}, last_t_low{0.0f};
    bool looks_behind = false;

    FloatV::mask_type active() const { return far >= 0.0f; }
};

}  // namespace slim
