#include "raytrace/trace/model_place.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

/// Models below this share of the scene have a frame of their own.
constexpr double kOwnFrameBelow = 1.0 / 16;

LanesOfVec lanes(const Vec3f& v) { return LanesOfVec(v); }

}  // namespace

ModelPlace ModelPlace::of(const Bbox& bounds, const SceneFrame& scene) {
    const double share = 0.5 * bounds.diagonal() / scene.unit;
    if (bounds.empty() || !(share < kOwnFrameBelow)) return {};  // empty: no surfels
    ModelPlace place;
    const Vec3d middle = (bounds.center() - scene.middle) / scene.unit;
    place.middle = to_float(middle), place.middle_low = to_float(middle - to_double(place.middle));
    // Two floats tell no more of the scene than this apart.
    place.unit = static_cast<float>(std::exp2(std::max(std::ceil(std::log2(share)), -48.0)));
    place.is_scene = false;
    return place;
}

SceneFrame ModelPlace::frame(const SceneFrame& scene) const {
    if (is_scene) return scene;
    return {scene.to_job(to_double(middle) + to_double(middle_low)),
            scene.unit * static_cast<double>(unit)};
}

TwoFloatVecs ModelPlace::to_scene(const TwoFloatVecs& p) const {
    const FloatV s(unit);
    return scaled_sum({p.high * s, p.low * s}, {lanes(middle), lanes(middle_low)}, FloatV(1.0f));
}

PlacedRays::PlacedRays(const ModelPlace& place, const RayPacket& scene_rays, const FloatV& far_low)
    : rays(scene_rays) {
    constexpr float kSqReach = 1.1f;  // every ball lies within 1
    const FloatV per_unit(1 / place.unit), none(0.0f);
    const TwoFloatVecs direction{rays.direction, rays.direction_low};
    TwoFloatVecs origin = scaled_sum({rays.origin, rays.origin_low},
                                     {lanes(-place.middle), lanes(-place.middle_low)}, per_unit);
    // The place nearest the middle, found twice: a float of the way there is no place from afar.
    const FloatV way = -origin.high.dot(rays.direction);
    TwoFloatVecs nearest = place_along(origin, direction, way);
    const FloatV rest = -nearest.high.dot(rays.direction);
    nearest = place_along(nearest, direction, rest);
    const FloatV sq_half = kSqReach - nearest.high.dot(nearest.high);
    const FloatV half = stdx::sqrt(stdx::max(sq_half, none)), middle = way + rest;
    const auto outside = middle > half;
    const TwoFloatVecs entry = place_along(nearest, direction, -half);
    start = sum_of(sum_of({way, none}, {rest, none}), {-half, none});
    start = {select<FloatV>(outside, start.high, none), select<FloatV>(outside, start.low, none)};
    rays.origin = select_vec(outside, entry.high, origin.high);
    rays.origin_low = select_vec(outside, entry.low, origin.low);
    rays.far = (scene_rays.far * per_unit - start.high) + (far_low * per_unit - start.low);
    if (rays.looks_behind)
        rays.last_t = (scene_rays.last_t * per_unit - start.high) +
                      (scene_rays.last_t_low * per_unit - start.low);
    const auto meets =
        scene_rays.active() && sq_half > 0.0f && middle + half >= 0.0f && rays.far >= 0.0f;
    rays.far = select<FloatV>(meets, rays.far, FloatV(-1.0f));
}

}  // namespace slim
