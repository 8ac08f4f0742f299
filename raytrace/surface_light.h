#pragma once

#include "raytrace/camera.h"
#include "raytrace/frame.h"
#include "raytrace/light_rig.h"
#include "raytrace/sample_grid.h"
#include "raytrace/whole_power.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace slim {

/// Points of a surface to shade, one per lane; scene coordinates.
struct ShadePoints {
    LanesOfVec point{Vec3f{}};
    LanesOfVec point_low{Vec3f{}};  ///< what its floats lack, where that is known
    LanesOfVec normal{Vec3f{0, 0, 1}};      ///< unit, turned to the eye
    LanesOfVec toward_eye{Vec3f{0, 0, 1}};  ///< unit
    LanesOfVec outward{Vec3f{0, 0, 1}};     ///< the normal that the surface has, facing whomever
    LanesOfVec tint{Vec3f{1, 1, 1}};  ///< the place's own colour, linear, times the material's
    FloatV clearance{0.0f};           ///< rays that leave start this far off the surface
    FloatV::mask_type on{false};
};

/// What one light does to a surface, times its colour.
struct LightSums {
    FloatV diffuse{0.0f}, shine{0.0f};
};

/// Lambert's and Blinn's terms (as in shade.cpp) of light from one place. unblocked(points, lanes,
/// incident) -> lanes that it reaches.
template <class Unblocked>
void add_light(const IncidentLight& incident, const ShadePoints& at, int shininess,
               const Unblocked& unblocked, LightSums& sums) {
    const FloatV facing = at.normal.dot(incident.toward);
    auto lit = at.on && facing > 0.0f && incident.strength > 0.0f;
    if (stdx::none_of(lit)) return;
    lit = unblocked(at, lit, incident);
    const FloatV strength = select<FloatV>(lit, incident.strength, FloatV(0.0f));
    const LanesOfVec half = (at.toward_eye + incident.toward).unit();
    // The highlight fades in with n.l, so that it cannot shine on the dark side.
    const FloatV fade = stdx::min(4.0f * facing, FloatV(1.0f));
    const FloatV high = stdx::max(at.normal.dot(half), FloatV(0.0f));
    sums.diffuse += strength * facing;
    sums.shine += strength * fade * whole_power(high, shininess);
}

/// The same of a whole light: the mean over its extent, unless `only_middle`.
template <class Unblocked>
LightSums gather_light(const SceneLight& light, const ShadePoints& at, int shininess,
                       const PixelBlock& block, std::uint64_t purpose, bool only_middle,
                       const Unblocked& unblocked) {
    LightSums sums;
    if (!light.has_extent || only_middle) {
        const FloatV middle(0.5f);
        add_light(light_at(light, at.point, middle, middle), at, shininess, unblocked, sums);
        sums.shine *= light.highlight;
        return sums;
    }
    const SampleGrid grid(light.samples);
    const LaneKeys keys(block, purpose);
    for (int i = 0; i < grid.n(); ++i) {
        FloatV s, t;
        grid.sample(i, keys, s, t);
        add_light(light_at(light, at.point, s, t), at, shininess, unblocked, sums);
    }
    const float share = 1 / static_cast<float>(grid.n());
    sums.diffuse *= share, sums.shine *= light.highlight * share;
    return sums;
}

/// The hemisphere of ambient light; `open` is the share of it that comes through.
inline LanesOfVec ambient_light(const SceneRig& rig, const LanesOfVec& normal, const FloatV& open) {
    const FloatV upward = 0.5f * (1.0f + normal.dot(LanesOfVec(rig.up)));
    return (LanesOfVec(rig.sky) * upward + LanesOfVec(rig.ground) * (1.0f - upward)) * open;
}

/// Light that the points send to the eye, linear. `purpose` tells the random numbers of one call
/// from another's.
template <class Unblocked>
LanesOfVec lit_color(const SceneRig& rig, const Material& material, const ShadePoints& at,
                     const FloatV& open, const PixelBlock& block, std::uint64_t purpose,
                     bool only_middle, const Unblocked& unblocked) {
    LanesOfVec diffuse = ambient_light(rig, at.normal, open), shine{Vec3f{}};
    for (std::size_t i = 0; i < rig.lights.size(); ++i) {
        const SceneLight& light = rig.lights[i];
        const LightSums sums =
            gather_light(light, at, material.shininess, block, purpose + i, only_middle,
                         [&](const ShadePoints& p, const auto& lit, const IncidentLight& incident) {
                             return light.shadows ? unblocked(p, lit, incident) : lit;
                         });
        diffuse = diffuse + LanesOfVec(light.color) * sums.diffuse;
        shine = shine + LanesOfVec(light.color) * sums.shine;
    }
    const LanesOfVec albedo{material.albedo.x * at.tint.x, material.albedo.y * at.tint.y,
                            material.albedo.z * at.tint.z};
    return {albedo.x * diffuse.x + material.specular * shine.x,
            albedo.y * diffuse.y + material.specular * shine.y,
            albedo.z * diffuse.z + material.specular * shine.z};
}

/// Writes the lanes of a block as premultiplied colour; `picture` is of the block's window.
void store_block(const PixelBlock& block, const LanesOfVec& color, const FloatV& alpha,
                 Picture& picture);

/// What was seen of a surface; the planes are those of `window`, a part of the view's picture.
struct SurfacePlanes {
    const PixelView& view;
    PixelWindow window;
    const GBuffer& buffer;                             ///< hits and positions
    const std::array<std::vector<float>, 3>& normals;  ///< turned to the eye: turned_normals
    const SampleMask* only = nullptr;                  ///< what of the window was drawn, if not all
    /// Colours of the hits, linear; empty: the material's alone.
    std::span<const Vec3f> tints = {};

    /// Some rows of them, as a part of the picture.
    PixelWindow band(const RowRange& rows) const {
        return {window.x, window.y + rows.begin, window.width, rows.end - rows.begin};
    }
    std::size_t index(const PixelBlock& block, int lane) const {
        return buffer.index(block.x_of(lane) - window.x, block.y_of(lane) - window.y);
    }
};

/// The surface in a block's pixels; clearances are 0.
ShadePoints load_points(const SurfacePlanes& planes, const SceneFrame& frame,
                        const PixelBlock& block);

/// Shades rows of a frame by any lights, without shadows and each light as if it were at its
/// middle: what forward projection can do. Rows, which count from the window's first, in parallel.
Picture shade_lit_rows(const SurfacePlanes& planes, const SceneFrame& frame, const LightRig& rig,
                       const Material& material, const RowRange& rows);

}  // namespace slim
