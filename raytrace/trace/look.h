#pragma once

#include "raytrace/light_rig.h"
#include "raytrace/shade.h"
#include "slim/base/vec.h"

#include <optional>
#include <vector>

namespace slim {

/// Ambient occlusion: the share of the directions above a surface, weighted by their cosine, in
/// which nothing is near.
struct Openness {
    double distance = 1;  ///< what is farther does not count; model units
    int samples = 36;     ///< rounded up to a square
};

/// A plane under the models: n.p = height, frame of the job. Seen from its upper side only, and one
/// with a colour keeps light from below off what is above it.
struct GroundPlane {
    Vec3d normal{0, 1, 0};
    double height = 0;
    /// Linear Rec.709; none: only the shadows on it are seen, as black of their strength over
    /// whatever is behind.
    std::optional<Vec3f> color;
};

/// What a traced picture looks like, besides its geometry.
struct TraceLook {
    LightRig rig;
    std::vector<Material> materials{
        Material{}};  ///< of each model; the last one of those that follow
    bool shadows = true;
    std::optional<Openness> openness;  ///< dims the ambient light
    std::optional<GroundPlane> ground;
    int bounces = 2;        ///< mirror images within mirror images
    Background background;  ///< what mirrors show where nothing is

    const Material& material(std::size_t model) const {
        return materials[model < materials.size() ? model : materials.size() - 1];
    }
};

}  // namespace slim
