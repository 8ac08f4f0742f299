#pragma once

#include "pipeline/render/render_config.h"
#include "raytrace/light_rig.h"
#include "slim/base/bbox.h"
#include "slim/base/vec.h"

#include <string>
#include <vector>

namespace slim {

/// What the words of a light are measured against; frame of the job.
struct LightSetting {
    ShadeView view;
    Bbox bounds;   ///< of the model
    Vec3d origin;  ///< world = origin + local
    Vec3d up{0, 1, 0};
};

/// The lights of --light: "KIND key=value ...; KIND ...".
///
///     key, fill  the shaded look's own, fixed to the camera; fill throws no shadows by itself
///     sun        azimuth= elevation=: degrees, clockwise seen from above, 0 where the front view
///                looks (north with --up z); or from=x,y,z, a direction
///     point      at=x,y,z
///     spot       at= to= cone= blur=: full angle in degrees, share of it over which it fades
///     rect       at= to= size=W,H
///     disc       at= to= size=DIAMETER
///     any        power= color=#rrggbb shadows=on|off
///     soft       angle= (sun, key, fill: angular diameter in degrees), samples=
///
/// Places are world coordinates; `to` is the middle of the model unless given. With power 1 a light
/// is as bright at `to` as the key light; without `to`, at half the shortest side of the model's
/// box from it if that is farther, so that a lamp in the middle of a room lights the walls. Throws
/// ConfigError naming the word.
std::vector<LightSource> parse_lights(const std::string& text, const LightSetting& setting);

/// Throws what parse_lights does, before there is a model.
void check_lights(const std::string& text);

/// The materials of --material, one a model: "color=#rrggbb specular= shininess= mirror=; ...";
/// color=scan takes the model's own colours. Throws ConfigError.
std::vector<Material> parse_materials(const std::string& text);

/// Whether one of them has the colours of the scan.
bool shades_scan_colors(const std::string& text);

/// Whether the shaded picture, and whether any, shows the colours of the scan.
bool tints_shaded(const RenderConfig& config, const std::vector<std::string>& aovs);
bool takes_colors(const RenderConfig& config, const std::vector<std::string>& aovs);

}  // namespace slim
