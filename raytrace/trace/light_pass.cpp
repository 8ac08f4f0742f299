#include "raytrace/trace/light_pass.h"

#include "raytrace/trace/light_tracer.h"
#include "raytrace/trace/openness_filter.h"
#include "raytrace/trace/primary_rays.h"

namespace slim {
namespace {

/// The surface in a block and what leaves it.
struct BlockSurface {
    ShadePoints at;
    std::array<std::uint16_t, kLanes> model{};
    FloatV open{1.0f};
};

/// A lane's place in two floats, where the frame keeps what one lacks.
void load_exact_point(const TracedSurface& surface, std::size_t pixel, int lane, ShadePoints& at) {
    const auto& low = surface.traced.position_low;
    const auto& p = surface.planes.buffer.position;
    const auto axis = [&](std::size_t a) { return double{p[a][pixel]} + double{low[a][pixel]}; };
    const SceneFrame& frame = surface.scene.frame();
    const Vec3d exact = (Vec3d{axis(0), axis(1), axis(2)} - frame.middle) / frame.unit;
    const Vec3f rounded = to_float(exact);
    at.point.set(lane, rounded), at.point_low.set(lane, to_float(exact - to_double(rounded)));
}

BlockSurface load_block(const TracedSurface& surface, std::span<const float> open,
                        const PixelBlock& block) {
    BlockSurface out{load_points(surface.planes, surface.scene.frame(), block), {}, FloatV(1.0f)};
    for (int lane = 0; lane < kLanes; ++lane) {
        if (!block.holds(lane)) continue;
        const auto k = static_cast<std::size_t>(lane);
        const std::size_t i = surface.planes.index(block, lane);
        if (!surface.traced.model.empty()) out.model[k] = surface.traced.model[i];
        const float unit = surface.scene.models()[out.model[k]].place.unit;
        out.at.clearance[k] = surface.traced.clearance[i] + unit * kPlaceRounding;
        if (!surface.traced.position_low[0].empty() && surface.planes.buffer.hit[i])
            load_exact_point(surface, i, lane, out.at);
        if (!open.empty()) out.open[k] = open[i];
    }
    return out;
}

TraceCounts sum_of(const std::vector<TraceCounts>& rows) {
    TraceCounts sum;
    for (const TraceCounts& c : rows) sum += c;
    return sum;
}

/// Distance of the surface from the rays' origins; infinite where there is none.
FloatV distance_of(const ShadePoints& at, const RayPacket& rays) {
    const LanesOfVec way = (at.point - rays.origin) + (at.point_low - rays.origin_low);
    return select<FloatV>(at.on, way.dot(rays.direction), FloatV(kFar));
}

FloatV load_narrow(const TracedSurface& surface, const PixelBlock& block) {
    FloatV out(0.0f);
    for (int lane = 0; lane < kLanes && !surface.narrow.empty(); ++lane)
        if (block.holds(lane))
            out[static_cast<std::size_t>(lane)] =
                surface.narrow[surface.planes.index(block, lane)];
    return out;
}

/// What is known of the ground's openness: where no surface is.
KnownOpenness load_ground(const TracedSurface& surface, std::span<const float> open,
                          const ShadePoints& at, const PixelBlock& block) {
    KnownOpenness out;
    if (open.empty()) return out;
    out.known = !at.on;
    for (int lane = 0; lane < kLanes; ++lane)
        if (block.holds(lane))
            out.open[static_cast<std::size_t>(lane)] = open[surface.planes.index(block, lane)];
    return out;
}

void light_block(const TracedSurface& surface, const LightTracer& tracer, bool ground,
                 const OpenPlanes& open, const RaySite& site, Picture& out) {
    const PixelBlock& block = site.block;
    const BlockSurface s = load_block(surface, open.surface, block);
    LanesOfVec color{Vec3f{}};
    FloatV alpha = select<FloatV>(s.at.on, FloatV(1.0f), FloatV(0.0f));
    if (stdx::any_of(s.at.on)) color = tracer.color(s.at, s.model, s.open, site);
    if (ground) {
        const RayPacket rays = rays_to_ground(surface.planes.view, surface.scene.frame(), block);
        FloatV ground_alpha;
        const LanesOfVec over =
            tracer.ground_color(rays, distance_of(s.at, rays), site, ground_alpha,
                                load_ground(surface, open.ground, s.at, block));
        color = over + color * (1.0f - ground_alpha);
        alpha = ground_alpha + alpha * (1.0f - ground_alpha);
    }
    store_block(block, color, alpha, out);
}

}  // namespace

std::vector<float> openness_plane(const TracedSurface& surface, const Openness& openness,
                                  const std::optional<GroundPlane>& ground, TraceCounts& counts) {
    std::vector<float> out(surface.planes.buffer.n_pixels(), 0.0f);
    std::vector<TraceCounts> rows(n_block_rows(surface.planes.window));
    TraceLook look;
    look.ground = ground;
    const LightTracer tracer(surface.scene, look);
    for_blocks(surface.planes.window, [&](std::size_t row, const PixelBlock& block) {
        const BlockSurface s = load_block(surface, {}, block);
        if (stdx::none_of(s.at.on)) return;
        const FloatV open = tracer.open_share(s.at, openness, {block, rows[row]},
                                              load_narrow(surface, block));
        for (int lane = 0; lane < kLanes; ++lane)
            if (const auto k = static_cast<std::size_t>(lane); s.at.on[k])
                out[surface.planes.index(block, lane)] = open[k];
    }, surface.planes.only);
    counts += sum_of(rows);
    return filtered_openness(surface.planes, out, openness.samples, surface.traced.position_low);
}

std::vector<float> ground_openness_plane(const TracedSurface& surface, const Openness& openness,
                                         const GroundPlane& ground, TraceCounts& counts) {
    const SurfacePlanes& planes = surface.planes;
    GBuffer seen;
    seen.reset(planes.buffer.width, planes.buffer.height, kPositionChannel | kNormalChannel);
    std::vector<float> out(seen.n_pixels(), 0.0f);
    std::vector<TraceCounts> rows(n_block_rows(planes.window));
    TraceLook look;
    look.ground = ground;
    const LightTracer tracer(surface.scene, look);
    for_blocks(planes.window, [&](std::size_t row, const PixelBlock& block) {
        ShadePoints at = tracer.ground_points(
            rays_to_ground(planes.view, surface.scene.frame(), block), FloatV(kFar));
        at.on = at.on && !load_points(planes, surface.scene.frame(), block).on;
        if (stdx::none_of(at.on)) return;
        const FloatV open = tracer.open_share(at, openness, {block, rows[row]});
        for (int lane = 0; lane < kLanes; ++lane) {
            const auto k = static_cast<std::size_t>(lane);
            if (!block.holds(lane) || !at.on[k]) continue;
            const std::size_t i = planes.index(block, lane);
            seen.hit[i] = 1, out[i] = open[k];
            const LanesOfVec &p = at.point, &n = at.normal;
            seen.position[0][i] = p.x[k], seen.position[1][i] = p.y[k],
            seen.position[2][i] = p.z[k];
            seen.normal[0][i] = n.x[k], seen.normal[1][i] = n.y[k], seen.normal[2][i] = n.z[k];
        }
    }, planes.only);
    counts += sum_of(rows);
    return filtered_openness({planes.view, planes.window, seen, seen.normal}, out,
                             openness.samples);
}

Picture light_rows(const TracedSurface& surface, const TraceLook& look, const OpenPlanes& open,
                   const RowRange& rows, TraceCounts& counts) {
    const PixelWindow band = surface.planes.band(rows);
    Picture out(band.width, band.height);
    std::vector<TraceCounts> row_counts(n_block_rows(band));
    const LightTracer tracer(surface.scene, look);
    for_blocks(band, [&](std::size_t row, const PixelBlock& block) {
        light_block(surface, tracer, look.ground.has_value(), open, {block, row_counts[row]}, out);
    }, surface.planes.only);
    counts += sum_of(row_counts);
    return out;
}

}  // namespace slim
