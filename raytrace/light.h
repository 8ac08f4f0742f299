#pragma once

#include "raytrace/lanes_of_vec.h"
#include "raytrace/scene_frame.h"
#include "slim/base/vec.h"

#include <cstdint>
#include <vector>

namespace slim {

enum class LightKind : std::uint8_t { directional, point, spot, rectangle, disc };

/// A light that stands still in space; frame of the job.
struct LightSource {
    LightKind kind = LightKind::directional;
    Vec3d toward{0, 1,
                 0};  ///< directional: to the light, unit. Others: against the way it shines, unit
    Vec3d position;   ///< all but directional: its middle
    /// Half its sides (rectangle), its radii (disc); of a directional light the tangents of its
    /// angular radius, across `toward`.
    Vec3d u_axis, v_axis;
    Vec3f color{
        1, 1,
        1};  ///< linear Rec.709, as Light::color, at normal incidence at the distance `reference`
    double reference = 1;  ///< model units; not of directional lights
    double cos_core = 1;   ///< spot: full strength within, none beyond cos_cone
    double cos_cone = 0;
    float highlight = 1;  ///< its share in highlights
    bool shadows = true;
    int samples = 16;  ///< of a light with an extent; rounded up to a square

    bool has_extent() const { return sq_length(u_axis) > 0 || sq_length(v_axis) > 0; }
};

/// A light in the floats of a scene.
struct SceneLight {
    LightKind kind;
    Vec3f toward, position, u_axis, v_axis;
    Vec3f color;
    float sq_reference, cos_core, cos_cone, highlight;
    bool shadows, has_extent;
    int samples;
};
SceneLight scene_light(const LightSource& light, const SceneFrame& frame);

/// Light that comes to some points from a place on a light.
struct IncidentLight {
    LanesOfVec toward;  ///< unit
    FloatV distance;    ///< infinite for directional lights; scene units
    FloatV strength;    ///< times the light's colour, at normal incidence
};

/// The place (s, t) in [0, 1]^2 of a light, its middle at (1/2, 1/2); discs by Shirley and Chiu's
/// map (1997), which keeps neighbours together. Strength falls with the square of the distance, and
/// of rectangles and discs with the cosine.
IncidentLight light_at(const SceneLight& light, const LanesOfVec& point, const FloatV& s,
                       const FloatV& t);

/// Concentric map of [0, 1]^2 to the unit disc.
void disc_point(const FloatV& s, const FloatV& t, FloatV& x, FloatV& y);

}  // namespace slim
