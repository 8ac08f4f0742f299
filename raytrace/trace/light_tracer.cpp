#include "raytrace/trace/light_tracer.h"

#include "raytrace/eye_surface.h"
#include "raytrace/trace/two_floats.h"

#include <algorithm>
#include <bit>

namespace slim {
namespace {

/// Random numbers of openness; those of lights count up from 0.
constexpr std::uint64_t kOpenness = 1 << 15;

/// Rays that leave surface points above them, in the lanes wanted.
RayPacket leaving(const ShadePoints& at, const FloatV::mask_type& wanted,
                  const LanesOfVec& direction, const FloatV& far) {
    RayPacket rays;
    const TwoFloatVecs origin =
        place_along({at.point, at.point_low}, {at.normal, LanesOfVec(Vec3f{})}, at.clearance);
    rays.origin = origin.high, rays.origin_low = origin.low, rays.direction = direction;
    rays.far = select<FloatV>(wanted, far, FloatV(-1.0f));
    rays.normal = at.outward, rays.leaves_surface = true;
    return rays;
}

/// Directions about a normal whose density goes with the cosine: points of a disc, raised to the
/// sphere.
LanesOfVec about(const LanesOfVec& n, const FloatV& s, const FloatV& t) {
    FloatV x, y;
    disc_point(s, t, x, y);
    const FloatV z = stdx::sqrt(stdx::max(1.0f - x * x - y * y, FloatV(0.0f)));
    // The basis of Duff et al. (JCGT 2017).
    const FloatV sign = lanes_copysign<FloatV>(FloatV(1.0f), n.z);
    const FloatV a = -1.0f / (sign + n.z), b = n.x * n.y * a;
    const LanesOfVec u{1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x},
        v{b, sign + n.y * n.y * a, -n.y};
    return u * x + v * y + n * z;
}

/// Normals of places that are seen along -toward_eye, to be lit by: where they look away a little,
/// a silhouette (silhouette_normal), turned round where they do so by more.
LanesOfVec facing(const LanesOfVec& normal, const LanesOfVec& toward_eye) {
    LanesOfVec out = normal;
    for (std::uint64_t bits = lane_bits(normal.dot(toward_eye) < 0.0f); bits != 0;
         bits &= bits - 1) {
        const int lane = std::countr_zero(bits);
        out.set(lane, silhouette_normal(normal.at(lane), toward_eye.at(lane)));
    }
    return out;
}

FloatV luminance(const LanesOfVec& c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }

}  // namespace

SceneGround::SceneGround(const GroundPlane& plane, const TraceScene& scene)
    : normal(to_float(plane.normal)), clearance(1e-5f) {
    const double exact =
        (plane.height - dot(plane.normal, scene.frame().middle)) / scene.frame().unit;
    height = static_cast<float>(exact),
    height_low = static_cast<float>(exact - static_cast<double>(height));
    for (const TraceModel& model : scene.models())
        clearance = std::min(clearance, 1e-5f * model.place.unit);
}

FloatV SceneGround::distance(const RayPacket& rays) const {
    const LanesOfVec n(normal);
    const FloatV above = (rays.origin.dot(n) - height) + (rays.origin_low.dot(n) - height_low);
    const FloatV down = -rays.direction.dot(n);
    const auto meets = above > 0.0f && down > 1e-6f;
    return select<FloatV>(meets, above / select<FloatV>(meets, down, FloatV(1.0f)), FloatV(kFar));
}

LightTracer::LightTracer(const TraceScene& scene, const TraceLook& look)
    : scene_(scene), look_(look), rig_(look.rig, scene.frame()) {
    if (look.ground) ground_.emplace(*look.ground, scene);
}

template <class Meets>
FloatV LightTracer::share_above(const ShadePoints& at, const FloatV& far, int samples,
                                const RaySite& site, Meets&& meets) const {
    const SampleGrid grid(samples, SampleGrid::Pixels::interleaved);
    const LaneKeys keys(site.block, site.purpose() + kOpenness);
    FloatV sum(0.0f);
    for (int i = 0; i < grid.n(); ++i) {
        FloatV s, t;
        grid.sample(i, keys, s, t);
        const RayPacket rays = leaving(at, at.on, about(at.normal, s, t), far);
        sum += select<FloatV>(meets(rays), FloatV(1.0f), FloatV(0.0f));
    }
    return sum * (1 / static_cast<float>(grid.n()));
}

FloatV LightTracer::free_share(const ShadePoints& at, const FloatV& far, int samples,
                               const RaySite& site) const {
    return share_above(at, far, samples, site, [&](const RayPacket& rays) {
        const auto free = scene_.unblocked(rays, site.counts);
        return ground_ ? free && ground_->distance(rays) > far : free;
    });
}

FloatV LightTracer::share_of_far_side(const ShadePoints& at, const FloatV& far, int samples,
                                      const RaySite& site) const {
    constexpr float kOpposite = -0.5f;  // cosine of the outward normals
    return share_above(at, far, samples, site, [&](const RayPacket& rays) {
        std::array<std::uint32_t, kLanes> model{};
        const FirstHits hits = scene_.first_hits(rays, model, site.counts);
        const LanesOfVec& g = hits.gradient;
        const auto opposite = g.dot(at.outward) < kOpposite * stdx::sqrt(g.dot(g));
        const auto front = g.dot(rays.direction) < 0.0f;
        return rays.active() && hits.t < kFar && (opposite || front);
    });
}

FloatV LightTracer::open_share(const ShadePoints& at, const Openness& openness,
                               const RaySite& site, const FloatV& narrow) const {
    constexpr float kThin = 0.1f;          // of the distance
    constexpr float kLeastClosed = 0.25f;  // by the far side: up to there nothing is thin
    const FloatV far(static_cast<float>(openness.distance / scene_.frame().unit));
    const FloatV open = free_share(at, far, openness.samples, site);
    ShadePoints inside = at;
    inside.on = at.on && at.normal.dot(at.outward) < 0.0f && open < 1.0f - kLeastClosed;
    if (stdx::none_of(inside.on)) return open;
    const FloatV closed = share_of_far_side(inside, far * kThin, openness.samples, site);
    // Of a half closed or more all.
    const FloatV thin = stdx::max(
        stdx::clamp(closed * (1 / kLeastClosed) - 1.0f, FloatV(0.0f), FloatV(1.0f)), narrow);
    ShadePoints outside = at;
    outside.normal = -at.normal, outside.on = inside.on && thin > 0.0f;
    if (stdx::none_of(outside.on)) return open;
    const FloatV more = free_share(outside, far, openness.samples, site) - open;
    return open + select<FloatV>(outside.on && more > 0.0f, thin * more, FloatV(0.0f));
}

FloatV::mask_type LightTracer::unblocked(const ShadePoints& at, const FloatV::mask_type& lit,
                                         const IncidentLight& light, TraceCounts& counts) const {
    const bool has_floor = ground_ && look_.ground->color;
    if (!look_.shadows && !has_floor) return lit;
    RayPacket rays = leaving(at, lit, light.toward, light.distance);
    auto reached = lit;
    if (has_floor) {
        reached = lit && !(ground_->distance(rays) < light.distance);
        rays.far = select<FloatV>(reached, rays.far, FloatV(-1.0f));
    }
    return look_.shadows ? reached && scene_.unblocked(rays, counts) : reached;
}

LanesOfVec LightTracer::background(const LanesOfVec& direction) const {
    const Background& b = look_.background;
    const FloatV upward = (0.5f + 0.5f * direction.dot(LanesOfVec(rig_.up)));
    return (LanesOfVec(b.top) * upward + LanesOfVec(b.bottom) * (1.0f - upward)) * FloatV(b.alpha);
}

LanesOfVec LightTracer::mirrored(const ShadePoints& at, const RaySite& site) const {
    const LanesOfVec& e = at.toward_eye;
    const LanesOfVec direction = (at.normal * (2.0f * at.normal.dot(e)) - e).unit();
    const RayPacket rays = leaving(at, at.on, direction, FloatV(kFar));
    const SurfaceHits hits = scene_.surface(rays, Derivatives::first, site.counts);
    const FloatV ground = ground_ ? ground_->distance(rays) : FloatV(kFar);
    LanesOfVec seen = background(direction);
    if (ground_) {
        FloatV alpha;
        const LanesOfVec plane = ground_color(rays, hits.t, site, alpha);
        seen = plane + seen * (1.0f - alpha);
    }
    const auto hit = at.on && hits.hit() && hits.t <= ground;
    if (stdx::none_of(hit)) return seen;
    ShadePoints there;
    there.point = hits.point, there.point_low = hits.point_low;
    there.toward_eye = -direction, there.on = hit;
    there.clearance = hits.clearance;
    there.outward = hits.normal;
    there.normal = facing(hits.normal, there.toward_eye);
    std::array<std::uint16_t, kLanes> model;
    for (std::size_t k = 0; k < kLanes; ++k) {
        model[k] = static_cast<std::uint16_t>(hits.model[k]);
        there.clearance[k] += scene_.models()[hits.model[k]].place.unit * kPlaceRounding;
    }
    return select_vec(hit, color(there, model, openness(there, site), site), seen);
}

LanesOfVec LightTracer::lit(const ShadePoints& at, const Material& material, const FloatV& open,
                            const RaySite& site) const {
    const LanesOfVec own = lit_color(
        rig_, material, at, open, site.block, site.purpose(), false,
        [&](const ShadePoints& p, const FloatV::mask_type& lanes, const IncidentLight& light) {
            return unblocked(p, lanes, light, site.counts);
        });
    if (!(material.mirror > 0) || site.level >= look_.bounces) return own;
    return own * FloatV(1 - material.mirror) +
           mirrored(at, site.behind_mirror()) * FloatV(material.mirror);
}

FloatV LightTracer::openness(const ShadePoints& at, const RaySite& site) const {
    return look_.openness ? open_share(at, *look_.openness, site) : FloatV(1.0f);
}

LanesOfVec LightTracer::color(const ShadePoints& at, const std::array<std::uint16_t, kLanes>& model,
                              const FloatV& open, const RaySite& site) const {
    LanesOfVec out{Vec3f{}};
    ShadePoints rest = at;
    while (stdx::any_of(rest.on)) {
        const std::uint16_t m =
            model[static_cast<std::size_t>(std::countr_zero(lane_bits(rest.on)))];
        ShadePoints own = rest;
        own.on = rest.on && FloatV([&](auto k) { return model[k] == m ? 1.0f : 0.0f; }) > 0.0f;
        out = select_vec(own.on, lit(own, look_.material(m), open, site), out);
        rest.on = rest.on && !own.on;
    }
    return out;
}

FloatV LightTracer::shadow_alpha(const ShadePoints& at, const FloatV& open,
                                 const RaySite& site) const {
    const Material white{{1, 1, 1}, 0, 1, 0};
    const auto all = [](const ShadePoints&, const FloatV::mask_type& lanes, const IncidentLight&) {
        return lanes;
    };
    const FloatV bright =
        luminance(lit_color(rig_, white, at, FloatV(1.0f), site.block, site.purpose(), false, all));
    const FloatV seen = luminance(lit(at, white, open, site));
    return select<FloatV>(at.on && bright > 0.0f, 1.0f - seen / bright, FloatV(0.0f));
}

ShadePoints LightTracer::ground_points(const RayPacket& rays, const FloatV& far) const {
    ShadePoints at;
    if (!ground_) return at;
    const FloatV t = ground_->distance(rays);
    at.on = rays.active() && t < far && t < kFar;
    const TwoFloatVecs place =
        place_along({rays.origin, rays.origin_low}, {rays.direction, rays.direction_low},
                    select<FloatV>(at.on, t, FloatV(0.0f)));
    at.point = place.high, at.point_low = place.low;
    at.outward = LanesOfVec{Vec3f{}};  // no surfel makes it
    at.normal = LanesOfVec(ground_->normal), at.toward_eye = -rays.direction,
    at.clearance = FloatV(ground_->clearance);
    return at;
}

LanesOfVec LightTracer::ground_color(const RayPacket& rays, const FloatV& far, const RaySite& site,
                                     FloatV& alpha, const KnownOpenness& known) const {
    alpha = FloatV(0.0f);
    const ShadePoints at = ground_points(rays, far);
    if (stdx::none_of(at.on)) return LanesOfVec{Vec3f{}};
    ShadePoints unknown = at;
    unknown.on = at.on && !known.known;
    FloatV open = known.open;
    if (stdx::any_of(unknown.on)) open = select<FloatV>(unknown.on, openness(unknown, site), open);
    if (!look_.ground->color) {
        alpha = shadow_alpha(at, open, site);
        return LanesOfVec{Vec3f{}};
    }
    const Material material{*look_.ground->color, 0, 1, 0};
    alpha = select<FloatV>(at.on, FloatV(1.0f), alpha);
    return select_vec(at.on, lit(at, material, open, site), LanesOfVec{Vec3f{}});
}

}  // namespace slim
