#include "raytrace/light_rig.h"

namespace slim {
namespace {

LightSource from_camera(const ShadeView& view, const Light& light) {
    LightSource out;
    const Vec3d toward = to_double(light.toward);
    out.toward = normalized(view.right * toward.x + view.up * toward.y + view.back * toward.z);
    out.color = light.color;
    return out;
}

}  // namespace

LightSource studio_key(const ShadeView& view) { return from_camera(view, Lighting{}.key); }

LightSource studio_fill(const ShadeView& view) {
    LightSource out = from_camera(view, Lighting{}.fill);
    out.highlight = 0, out.shadows = false;
    return out;
}

LightRig studio_rig(const ShadeView& view) {
    LightRig rig;
    rig.lights = {studio_key(view), studio_fill(view)};
    rig.up = view.up;
    return rig;
}

SceneRig::SceneRig(const LightRig& rig, const SceneFrame& frame)
    : sky(rig.sky), ground(rig.ground), up(to_float(rig.up)) {
    for (const LightSource& light : rig.lights) lights.push_back(scene_light(light, frame));
}

}  // namespace slim
