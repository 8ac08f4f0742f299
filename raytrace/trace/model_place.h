#pragma once

#include "raytrace/scene_frame.h"
#include "raytrace/trace/ray_packet.h"
#include "raytrace/trace/two_floats.h"
#include "slim/base/bbox.h"

namespace slim {

/// Where the frame of a model's floats lies in the scene's. It is the scene's own unless the model
/// is much smaller: a surfel's floats are as exact as those of its centre are, so that a model a
/// share s of the scene would lose log2(1 / s) bits (notes/0004).
struct ModelPlace {
    Vec3f middle{}, middle_low{};  ///< scene coordinates, in two floats
    float unit = 1;                ///< scene units; a power of two
    bool is_scene = true;          ///< middle 0, unit 1

    /// Of a model whose balls lie in `bounds` (frame of the job).
    static ModelPlace of(const Bbox& bounds, const SceneFrame& scene);

    /// The model's own frame in the job's.
    SceneFrame frame(const SceneFrame& scene) const;
    /// A place of the model's own frame in scene coordinates.
    TwoFloatVecs to_scene(const TwoFloatVecs& p) const;
};

/// A packet in a model's own frame, from where it enters the model's sphere on; lanes that miss it
/// have no ray.
struct PlacedRays {
    RayPacket rays;
    TwoFloats start;  ///< how far that is from the packet's origin; own units

    /// `far_low` is what the floats of the packet's far ends lack.
    PlacedRays(const ModelPlace& place, const RayPacket& scene_rays, const FloatV& far_low = 0.0f);
};

}  // namespace slim
