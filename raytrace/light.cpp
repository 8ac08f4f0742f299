#include "raytrace/light.h"

#include <limits>
#include <numbers>

namespace slim {
namespace {

/// sin(a pi / 4) and cos(a pi / 4) for |a| <= 1, to about 1e-6: the first terms of Taylor's series.
void eighth_turn(const FloatV& a, FloatV& sin, FloatV& cos) {
    const FloatV x = a * static_cast<float>(std::numbers::pi / 4), q = x * x;
    sin = x * (1.0f + q * (-1.0f / 6 + q * (1.0f / 120 - q * (1.0f / 5040))));
    cos = 1.0f + q * (-0.5f + q * (1.0f / 24 + q * (-1.0f / 720 + q * (1.0f / 40320))));
}

/// 0 up to a, 1 from b on, without kinks (3 t^2 - 2 t^3).
FloatV smooth_step(float a, float b, const FloatV& x) {
    const FloatV t =
        stdx::min(stdx::max((x - a) / std::max(b - a, 1e-6f), FloatV(0.0f)), FloatV(1.0f));
    return t * t * (3.0f - 2.0f * t);
}

/// The point of a light in its own plane, in [-1, 1]^2.
void place_on(const SceneLight& light, const FloatV& s, const FloatV& t, FloatV& x, FloatV& y) {
    if (light.kind != LightKind::rectangle) return disc_point(s, t, x, y);
    x = 2.0f * s - 1.0f, y = 2.0f * t - 1.0f;
}

}  // namespace

void disc_point(const FloatV& s, const FloatV& t, FloatV& x, FloatV& y) {
    const FloatV a = 2.0f * s - 1.0f, b = 2.0f * t - 1.0f;
    const auto wide = stdx::abs(a) > stdx::abs(b);
    const FloatV r = select<FloatV>(wide, a, b), other = select<FloatV>(wide, b, a);
    const FloatV share = other / select<FloatV>(stdx::abs(r) > 0.0f, r, FloatV(1.0f));
    FloatV sin, cos;
    eighth_turn(share, sin, cos);
    x = r * select<FloatV>(wide, cos, sin);
    y = r * select<FloatV>(wide, sin, cos);
}

SceneLight scene_light(const LightSource& light, const SceneFrame& frame) {
    const double per_unit = light.kind == LightKind::directional ? 1 : 1 / frame.unit;
    const double reference = light.reference / frame.unit;
    return {light.kind,
            to_float(light.toward),
            frame.from_job(light.position),
            to_float(light.u_axis * per_unit),
            to_float(light.v_axis * per_unit),
            light.color,
            static_cast<float>(reference * reference),
            static_cast<float>(light.cos_core),
            static_cast<float>(light.cos_cone),
            light.highlight,
            light.shadows,
            light.has_extent(),
            light.samples};
}

IncidentLight light_at(const SceneLight& light, const LanesOfVec& point, const FloatV& s,
                       const FloatV& t) {
    FloatV x(0.0f), y(0.0f);
    if (light.has_extent) place_on(light, s, t, x, y);
    const LanesOfVec across = LanesOfVec(light.u_axis) * x + LanesOfVec(light.v_axis) * y;
    if (light.kind == LightKind::directional)
        return {(LanesOfVec(light.toward) + across).unit(),
                FloatV(std::numeric_limits<float>::infinity()), FloatV(1.0f)};
    const LanesOfVec way = LanesOfVec(light.position) + across - point;
    const FloatV sq = stdx::max(way.dot(way), FloatV(1e-12f)), inverse = inverse_sqrt(sq);
    IncidentLight out{way * inverse, sq * inverse, light.sq_reference / sq};
    if (light.kind == LightKind::point) return out;
    const FloatV cosine = out.toward.dot(LanesOfVec(light.toward));
    out.strength = out.strength * (light.kind == LightKind::spot
                                       ? smooth_step(light.cos_cone, light.cos_core, cosine)
                                       : stdx::max(cosine, FloatV(0.0f)));
    return out;
}

}  // namespace slim
