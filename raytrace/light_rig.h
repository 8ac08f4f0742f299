#pragma once

#include "raytrace/light.h"
#include "raytrace/shade.h"
#include "slim/base/vec.h"

#include <span>
#include <vector>

namespace slim {

/// What a surface is made of.
struct Material {
    Vec3f albedo = Lighting{}.albedo;  ///< linear Rec.709
    float specular = Lighting{}.specular;
    int shininess = Lighting{}.shininess;  ///< exponent of the highlight, at least 1
    float mirror = 0;                      ///< share of what is seen that is a mirror image, [0, 1]
    bool of_scan = false;                  ///< the albedo is to be times the scan's own colours

    bool operator==(const Material&) const = default;
};

/// The lights of a picture, and a hemisphere of ambient light.
struct LightRig {
    std::vector<LightSource> lights;
    Vec3f sky = Lighting{}.sky,
          ground = Lighting{}.ground;  ///< on a normal along `up`, and against it
    Vec3d up{0, 1, 0};                 ///< unit; the camera's
};

/// The key and the fill light of the shaded look, which stand still relative to the camera; only
/// the key throws shadows.
LightSource studio_key(const ShadeView& view);
LightSource studio_fill(const ShadeView& view);
LightRig studio_rig(const ShadeView& view);

/// A rig in the floats of a scene.
struct SceneRig {
    std::vector<SceneLight> lights;
    Vec3f sky, ground, up;

    SceneRig(const LightRig& rig, const SceneFrame& frame);
};

}  // namespace slim
