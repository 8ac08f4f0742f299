#include "pipeline/render/render_trace.h"

#include "pipeline/contains.h"
#include "pipeline/input_kind.h"
#include "pipeline/render/ray_options.h"
#include "pipeline/render/render_bands.h"
#include "pipeline/render/render_colors.h"
#include "pipeline/render/render_lights.h"
#include "raytrace/narrow_backs.h"
#include "raytrace/trace/light_pass.h"
#include "slim/base/error.h"
#include "slim/tree/drawn_beyond.h"
#include "slim/tree/drawn_bounds.h"
#include "slim/tree/drawn_hull.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace slim {
namespace {

LightRig rig_of(const RenderConfig& config, const ModelHeader& header, const ShadeView& view) {
    LightRig rig;
    rig.lights = parse_lights(config.light,
                              {view, header.bounds, header.origin, up_vector(up_axis(config))});
    const auto ambient = static_cast<float>(config.ambient);
    rig.sky = rig.sky * ambient, rig.ground = rig.ground * ambient, rig.up = view.up;
    return rig;
}

Openness openness_of(const RenderConfig& config, const ModelHeader& header) {
    return {config.ao_distance > 0 ? config.ao_distance : 0.25 * header.bounds.diagonal(),
            config.ao_samples};
}

GroundPlane ground_of(const RenderConfig& config, const TracedModels& models) {
    const Vec3d up = up_vector(up_axis(config));
    return {up, ground_level(config, models) - dot(up, models.header().origin),
            ground_color(config)};
}

std::optional<GroundPlane> wanted_ground(const FrameLight& light) {
    if (!light.config.ground) return std::nullopt;
    return ground_of(light.config, *light.traced);
}

TraceLook look_of(const FrameLight& light, const ShadeView& view) {
    const RenderConfig& config = light.config;
    TraceLook look;
    look.rig = rig_of(config, light.header, view);
    look.materials = parse_materials(config.material);
    look.shadows = config.shadows;
    if (config.ao) look.openness = openness_of(config, light.header);
    look.ground = wanted_ground(light);
    look.bounces = config.bounces;
    look.background = parse_background(config.background, false);
    return look;
}

PictureSize buffer_size(const RenderedFrame& frame, int factor = 1) {
    return {frame.buffer.width / factor, frame.buffer.height / factor};
}

/// A frame's planes as shading takes them.
struct FramePlanes {
    std::array<std::vector<float>, 3> normals;
    SurfacePlanes planes;

    explicit FramePlanes(const RenderedFrame& frame)
        : normals(turned(frame)),
          planes{frame.pixels, frame.window, frame.buffer, normals, frame.only, frame.tints} {}
    FramePlanes(const FramePlanes&) = delete;
    FramePlanes& operator=(const FramePlanes&) = delete;

private:
    static std::array<std::vector<float>, 3> turned(const RenderedFrame& frame) {
        const GBuffer& b = frame.buffer;
        return turned_normals(b.width, b.height, frame.view,
                              {b.normal[0], b.normal[1], b.normal[2]}, b.hit);
    }
};

void shade_traced(const FrameLight& light, int factor, RenderedFrame& frame) {
    const FramePlanes planes(frame);
    const TracedSurface surface{light.traced->scene(), planes.planes, frame.traced};
    const TraceLook look = look_of(light, frame.view);
    OpenPlanes open;
    if (light.config.ao) open = {frame.open, frame.ground_open};
    frame.shaded =
        paint_in_bands(buffer_size(frame), buffer_size(frame, factor), [&](const RowRange& rows) {
            return light_rows(surface, look, open, rows, frame.light_counts);
        });
}

/// Forward projection with lights or a material of one's own.
void shade_lit(const FrameLight& light, int factor, RenderedFrame& frame) {
    const FramePlanes planes(frame);
    const SceneFrame scene{light.header.bounds.center(),
                           std::max(0.5 * light.header.bounds.diagonal(), 1e-300)};
    const LightRig rig = rig_of(light.config, light.header, frame.view);
    const Material material = parse_materials(light.config.material)[0];
    frame.shaded =
        paint_in_bands(buffer_size(frame), buffer_size(frame, factor), [&](const RowRange& rows) {
            return shade_lit_rows(planes.planes, scene, rig, material, rows);
        });
}

/// The look that shade_rows has built in.
void shade_plain(int factor, RenderedFrame& frame) {
    const GBuffer& b = frame.buffer;
    const NormalPlanes normals{b.normal[0], b.normal[1], b.normal[2]};
    const auto rows_into = [&](const RowRange& rows, Picture& out) {
        shade_rows(b.width, b.height, frame.view, normals, b.hit, rows, {}, out);
    };
    if (factor == 1) return rows_into({0, b.height}, frame.shaded);
    frame.shaded =
        paint_in_bands(buffer_size(frame), buffer_size(frame, factor), [&](const RowRange& rows) {
            Picture band;
            rows_into(rows, band);
            return band;
        });
}

std::vector<Vec3d> corners_of(const Bbox& box) {
    std::vector<Vec3d> corners;
    for (const double x : {box.lo.x, box.hi.x})
        for (const double y : {box.lo.y, box.hi.y})
            for (const double z : {box.lo.z, box.hi.z}) corners.push_back({x, y, z});
    return corners;
}

bool is_plain(const RenderConfig& config) {
    const RenderConfig usual;
    return config.light == usual.light && config.material == usual.material &&
           config.ambient == usual.ambient;
}

}  // namespace

Channels light_channels(const RenderConfig& config, const std::vector<std::string>& aovs) {
    const bool shaded = contains(aovs, "shaded"), open = contains(aovs, "ao");
    Channels channels = 0;
    if (is_traced(config) ? shaded || open : shaded && !is_plain(config))
        channels |= kNormalChannel | kPositionChannel;
    if (shaded && shades_scan_colors(config.material)) channels |= kSurfelIdChannel;
    return channels;
}

namespace {

void append(const std::vector<Vec3d>& more, std::vector<Vec3d>& places) {
    places.insert(places.end(), more.begin(), more.end());
}

/// The hull of a model of few leaves whose discs reach far beyond its points, where kept hulls end;
/// empty of others.
std::vector<Vec3d> far_hull(const SurfelTree& tree, bool loose, const Bbox& drawn,
                            std::vector<std::uint32_t>* visited) {
    constexpr std::size_t kFewNodes = 400;
    if (tree.n_nodes() > kFewNodes) return {};
    if (visited)
        for (std::uint32_t i = 0; i < tree.n_nodes(); ++i) visited->push_back(i);
    const BeyondBox beyond = drawn_beyond(tree, loose, drawn);
    if (beyond.places.empty()) return {};
    std::vector<Vec3d> hull = drawn_hull(tree, false, beyond.box);
    if (loose) append(drawn_hull(tree, true, beyond.box), hull);
    append(beyond.places, hull);
    return hull;
}

}  // namespace

ModelHeader drawn_header(const SurfelTree& tree, bool loose, std::vector<std::uint32_t>* visited) {
    ModelHeader header = tree.header();
    header.bounds = drawn_bounds(tree, loose, visited);
    if (loose) append(header.loose_hull, header.hull);
    const std::vector<Vec3d> far = far_hull(tree, loose, header.bounds, visited);
    if (!far.empty()) header.hull = far;
    return header;
}

namespace {

/// A scene's bounds and hull with those of a further model; of one without a hull the corners of
/// its bounds.
void add_drawn(const ModelHeader& drawn, const Vec3d& offset, ModelHeader& scene) {
    if (scene.hull.empty()) scene.hull = corners_of(scene.bounds);
    for (const Vec3d& p : drawn.hull.empty() ? corners_of(drawn.bounds) : drawn.hull)
        scene.hull.push_back(p + offset);
    scene.bounds.extend(drawn.bounds.lo + offset);
    scene.bounds.extend(drawn.bounds.hi + offset);
}

}  // namespace

TracedModels::TracedModels(const RenderConfig& config, const SurfelTree& first)
    : header_(drawn_header(first, config.loose)) {
    std::vector<ScenePart> parts{{&first, {}}};
    for (const std::string& path : config.add) {
        require_model(path);
        files_.push_back(std::make_unique<ModelFile>(ModelFile::open_surface(path)));
        trees_.push_back(std::make_unique<SurfelTree>(files_.back()->tree()));
        const SurfelTree& tree = *trees_.back();
        if (tree.header().n_leaves == 0)
            throw DataError(path + ": a model without surfels cannot be drawn");
        const Vec3d offset = tree.header().origin - header_.origin;
        parts.push_back({&tree, offset});
        add_drawn(drawn_header(tree, config.loose), offset, header_);
    }
    if (!trees_.empty()) header_.diagonal = header_.bounds.diagonal();
    const auto start = std::chrono::steady_clock::now();
    scene_ = std::make_unique<TraceScene>(parts, config.loose);
    build_ms_ =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    if (config.ground) lowest_ = lowest_along(up_vector(up_axis(config)));
}

std::vector<const ModelHeader*> TracedModels::headers() const {
    std::vector<const ModelHeader*> out;
    for (const ScenePart& part : scene_->parts()) out.push_back(&part.tree->header());
    return out;
}

double ground_level(const RenderConfig& config, const TracedModels& models) {
    const double standing =
        models.lowest() + dot(up_vector(up_axis(config)), models.header().origin);
    return ground_height(config).value_or(standing);
}

double TracedModels::lowest_along(const Vec3d& up) const {
    double lowest = INFINITY;
    for (const ScenePart& part : scene_->parts()) {
        if (part.tree->sharp().empty()) continue;
        for (const Vec3d& place : part.tree->header().hull)
            lowest = std::min(lowest, dot(place + part.offset, up));
    }
    for (const TraceModel& model : scene_->models()) {
        std::vector<double> heights;
        heights.reserve(model.records.size());
        for (const TraceRecord& r : model.records)
            heights.push_back(dot(Vec3d{r.center[0], r.center[1], r.center[2]}, up));
        if (heights.empty()) continue;
        const auto low = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 1000);
        std::nth_element(heights.begin(), low, heights.end());
        lowest = std::min(lowest, *low * model.frame.unit + dot(model.frame.middle, up));
    }
    return std::isfinite(lowest) ? lowest : dot(header_.bounds.lo, up);
}

void find_openness(const FrameLight& light, RenderedFrame& frame) {
    const FramePlanes planes(frame);
    const GBuffer& b = frame.buffer;
    const std::vector<float> narrow = narrow_backs(
        b.width, b.height, frame.view, {b.normal[0], b.normal[1], b.normal[2]}, b.hit);
    const TracedSurface surface{light.traced->scene(), planes.planes, frame.traced, narrow};
    frame.open = openness_plane(surface, openness_of(light.config, light.header),
                                wanted_ground(light), frame.light_counts);
    frame.ground_open.clear();
    if (light.config.ao && light.config.ground)
        frame.ground_open = ground_openness_plane(surface, openness_of(light.config, light.header),
                                                  *wanted_ground(light), frame.light_counts);
}

bool lights_are_below_ground(const FrameLight& light, const ShadeView& view) {
    if (!light.traced || !light.config.ground) return false;
    const GroundPlane ground = ground_of(light.config, *light.traced);
    const std::vector<LightSource> lights = rig_of(light.config, light.header, view).lights;
    return !lights.empty() &&
           std::all_of(lights.begin(), lights.end(), [&](const LightSource& l) {
               return l.kind == LightKind::directional
                          ? dot(l.toward, ground.normal) <= 0
                          : dot(l.position, ground.normal) <= ground.height;
           });
}

void shade_frame(const FrameLight& light, int factor, RenderedFrame& frame) {
    frame.tints.clear();
    if (light.colors) frame.tints = scan_colors(*light.colors, frame);
    if (light.traced)
        shade_traced(light, factor, frame);
    else if (is_plain(light.config))
        shade_plain(factor, frame);
    else
        shade_lit(light, factor, frame);
}

}  // namespace slim
