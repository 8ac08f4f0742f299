#include "raytrace/surface_light.h"

#include <bit>

namespace slim {

void store_block(const PixelBlock& block, const LanesOfVec& color, const FloatV& alpha,
                 Picture& picture) {
    for (int lane = 0; lane < kLanes; ++lane) {
        if (!block.holds(lane)) continue;
        const auto k = static_cast<std::size_t>(lane);
        float* p =
            picture.pixel(block.x_of(lane) - block.window.x, block.y_of(lane) - block.window.y);
        p[0] = color.x[k], p[1] = color.y[k], p[2] = color.z[k], p[3] = alpha[k];
    }
}

ShadePoints load_points(const SurfacePlanes& planes, const SceneFrame& frame,
                        const PixelBlock& block) {
    ShadePoints out;
    FloatV on(0.0f);
    for (int lane = 0; lane < kLanes; ++lane) {
        if (!block.holds(lane)) continue;
        const std::size_t i = planes.index(block, lane);
        if (!planes.buffer.hit[i]) continue;
        const auto& p = planes.buffer.position;
        const auto& n = planes.normals;
        on[static_cast<std::size_t>(lane)] = 1;
        out.point.set(lane, frame.from_job({p[0][i], p[1][i], p[2][i]}));
        out.normal.set(lane, {n[0][i], n[1][i], n[2][i]});
        const auto& own = planes.buffer.normal;
        out.outward.set(lane, {own[0][i], own[1][i], own[2][i]});
        if (!planes.tints.empty()) out.tint.set(lane, planes.tints[i]);
        const Vec3d direction =
            planes.view.ray_direction(block.x_of(lane) + 0.5, block.y_of(lane) + 0.5);
        out.toward_eye.set(lane, to_float(-direction));
    }
    out.on = on > 0.0f;
    return out;
}

Picture shade_lit_rows(const SurfacePlanes& planes, const SceneFrame& frame, const LightRig& rig,
                       const Material& material, const RowRange& rows) {
    Picture out(planes.window.width, rows.end - rows.begin);
    const SceneRig scene_rig(rig, frame);
    const auto all = [](const ShadePoints&, const FloatV::mask_type& lit, const IncidentLight&) {
        return lit;
    };
    for_blocks(planes.band(rows), [&](std::size_t, const PixelBlock& block) {
        const ShadePoints at = load_points(planes, frame, block);
        if (stdx::none_of(at.on)) return;
        const LanesOfVec color =
            lit_color(scene_rig, material, at, FloatV(1.0f), block, 0, true, all);
        const FloatV alpha = select<FloatV>(at.on, FloatV(1.0f), FloatV(0.0f));
        store_block(block, select_vec(at.on, color, LanesOfVec(Vec3f{})), alpha, out);
    }, planes.only);
    return out;
}

}  // namespace slim
