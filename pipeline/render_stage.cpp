#include "pipeline/render_stage.h"

#include "formats/atomic_file.h"
#include "formats/image_io.h"
#include "formats/model_file.h"
#include "pipeline/input_kind.h"
#include "pipeline/manifest.h"
#include "pipeline/render_aov.h"
#include "pipeline/render_bands.h"
#include "pipeline/render_files.h"
#include "pipeline/render_lines.h"
#include "pipeline/render_maps.h"
#include "pipeline/render_trace.h"
#include "pipeline/render_view.h"
#include "raytrace/brute/brute_renderer.h"
#include "raytrace/lines/stroke.h"
#include "raytrace/project/forward_renderer.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <optional>

namespace slim {
namespace {

using Json = nlohmann::json;

/// All that is fixed before the first pixel.
struct RenderJob {
    const RenderConfig& config;
    const SurfelTree& tree;
    std::vector<std::string> aovs;
    OutputPlan plan;
    PictureSize size;
    Camera camera;
    std::vector<LineKind> lines;  ///< in the order of drawing
    const TracedModels* traced = nullptr;  ///< with --mode raytrace

    FrameLight light() const { return {config, traced ? traced->header() : tree.header(), camera, traced}; }
    Channels channels(const std::vector<std::string>& of) const {
        return channels_of(of, config.light_maps) | light_channels(config, of);
    }

    /// What the frame that lines are found in must hold for them.
    Channels for_lines() const { return line_channels(lines, tree.header().degree); }
    bool wants(const char* aov) const {
        return std::find(aovs.begin(), aovs.end(), aov) != aovs.end();
    }
};

double milliseconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
        .count();
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const std::size_t n = values.size();
    return n % 2 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

RenderStats render_surface(const RenderJob& job, const RenderRequest& request, RenderedFrame& frame) {
    if (job.traced) return render_traced(job.traced->scene(), request, frame.buffer, &frame.traced);
    return job.config.mode == "brute" ? render_brute(job.tree, request, frame.buffer)
                                      : render_forward(job.tree, request, frame.buffer);
}

/// Projection, shading and lines: what a frame time means.
RenderStats draw_frame(const RenderJob& job, int factor, Channels wanted, bool with_shading,
                       RenderedFrame& frame) {
    frame.size = {job.size.width * factor, job.size.height * factor};
    frame.view = shade_view(job.camera, frame.size);
    // LOD pixels are the picture's own: supersampling smooths edges, it does not refine the model.
    const RenderRequest request{job.camera, frame.size.width, frame.size.height, wanted,
                                job.config.lod * factor, {}, job.config.loose};
    const RenderStats stats = render_surface(job, request, frame);
    frame.light_counts = {};
    const FrameLight light = job.light();
    // The plain frame beside a fine one may be for ids only.
    const bool has_surface = frame.buffer.has(kNormalChannel | kPositionChannel);
    if (has_surface && (job.wants("ao") || (with_shading && job.config.ao)))
        find_openness(light, frame);
    if (with_shading) shade_frame(light, job.size, frame);
    // Lines are found at the picture's own size: their strokes are smooth as they are.
    if (factor == 1) frame.lines = find_lines(job.camera, job.tree.header(), frame, job.lines);
    return stats;
}

/// The frames of a run: `fine` for pictures that are averaged (twice the size with supersample 2),
/// `plain` for all else. Without supersampling both are the same one.
struct Frames {
    RenderedFrame plain, fine;
    bool has_fine = false;
    RenderStats stats;
    double median_ms = 0;

    const RenderedFrame& for_aov(const std::string& aov) const {
        return has_fine && is_filterable(aov) ? fine : plain;
    }
};

void require_hits(const RenderJob& job, const RenderStats& stats) {
    if (stats.covered_pixels > 0) return;
    const ModelHeader& m = job.tree.header();
    const Vec3d lo = m.bounds.lo + m.origin, hi = m.bounds.hi + m.origin;
    throw NumericalError(
        fmt::format("{}: not one of {}x{} pixels meets the surface: camera {}, model from ({:g}, "
                    "{:g}, {:g}) to "
                    "({:g}, {:g}, {:g}). --camera takes the eye, the target and the up axis in "
                    "these coordinates; "
                    "a named camera, as --camera iso, frames the whole model{}",
                    job.config.model, job.size.width, job.size.height,
                    describe(job.camera, m.origin), lo.x, lo.y, lo.z, hi.x, hi.y, hi.z,
                    stats.loose_hidden > 0 ? "; --loose draws the loose surfels seen here" : ""));
}

/// Renders the frame of a factor as often as the job says; returns the median time.
double draw_repeatedly(const RenderJob& job, int factor, Channels wanted, StageContext& context,
                       RenderedFrame& frame, RenderStats& stats) {
    std::vector<double> times;
    const auto repeats = static_cast<std::uint64_t>(job.config.repeat);
    for (std::uint64_t k = 0; k < repeats; ++k) {
        context.reporter.progress("frames", k, repeats);
        const auto start = std::chrono::steady_clock::now();
        stats = draw_frame(job, factor, wanted, job.wants("shaded"), frame);
        times.push_back(milliseconds_since(start));
    }
    return median(times);
}

/// What the plain frame is for: data files take all, pictures only what is never averaged.
std::vector<std::string> plain_aovs(const RenderJob& job) {
    std::vector<std::string> aovs = job.aovs;
    if (job.config.supersample > 1 && job.plan.exr.empty()) std::erase_if(aovs, is_filterable);
    return aovs;
}

/// What the fine frame is for: pictures, and the colour in a data file.
std::vector<std::string> fine_aovs(const RenderJob& job) {
    std::vector<std::string> aovs;
    if (job.config.supersample == 1) return aovs;
    for (const std::string& aov : job.aovs) {
        const bool drawn = std::find(job.plan.drawn.begin(), job.plan.drawn.end(), aov) !=
                           job.plan.drawn.end();
        if (is_filterable(aov) && (drawn || aov == "shaded")) aovs.push_back(aov);
    }
    return aovs;
}

Frames draw_frames(const RenderJob& job, StageContext& context) {
    const auto plain = plain_aovs(job), fine = fine_aovs(job);
    const Channels plain_channels = job.channels(plain) | job.for_lines();
    Frames frames;
    frames.has_fine = !fine.empty();
    if (frames.has_fine) {
        frames.median_ms = draw_repeatedly(job, job.config.supersample, job.channels(fine),
                                           context, frames.fine, frames.stats);
        if (!plain.empty() || !job.lines.empty())
            draw_frame(job, 1, plain_channels, false, frames.plain);
    } else {
        frames.median_ms = draw_repeatedly(job, 1, plain_channels, context, frames.plain, frames.stats);
    }
    require_hits(job, frames.stats);
    if (job.wants("truth_distance"))
        frames.plain.truth_distance =
            truth_distances(job.config, job.tree.header().origin, frames.plain.buffer);
    return frames;
}

Json range_json(const ValueRange& range) { return Json::array({range.lo, range.hi}); }

void write_png(const std::string& path, const Picture& picture, const ImageMetadata& metadata) {
    const Picture8 encoded = encode_srgb8(picture);
    write_png_srgb8(path, encoded.width, encoded.height, encoded.rgba, metadata);
}

/// Collects what was written, for the result and the manifest.
struct Written {
    std::vector<std::filesystem::path> files;
    Json ranges = Json::object();
};

void write_aov(const RenderJob& job, std::size_t k, const Frames& frames, ImageMetadata metadata,
               StageContext& context, Written& written) {
    const std::string& aov = job.plan.drawn[k];
    AovPicture drawn =
        draw_aov(job.config, aov, frames.for_aov(aov), job.tree.header().bounds, job.size);
    Picture& picture = drawn.picture;
    const LegendPlace place =
        drawn.legend ? best_legend_place(*drawn.legend, picture) : LegendPlace::right;
    composite_over(
        parse_background(job.config.background, drawn.legend.has_value() || aov == "lines"), picture);
    draw_lines(frames.plain.lines, picture);
    if (drawn.legend) {
        const ValueRange& range = drawn.legend->range;
        written.ranges[aov] = range_json(range);
        metadata["slim:range." + aov] = fmt::format("{:.17g} {:.17g}", range.lo, range.hi);
    }
    if (drawn.legend && job.config.legend) {
        if (!burn_legend(*drawn.legend, picture, place))
            context.reporter.warn(job.plan.pngs[k].string() +
                                  ": too small for a legend; see the SVG beside it");
        const std::string svg = job.plan.legend(aov).string();
        write_file_atomically(svg, legend_svg(*drawn.legend));
        written.files.push_back(svg);
    }
    write_png(job.plan.pngs[k].string(), picture, metadata);
    written.files.push_back(job.plan.pngs[k]);
}

void write_data(const RenderJob& job, const Frames& frames, const ImageMetadata& metadata,
                Written& written) {
    // Colour may be averaged, data never: they come from the frame at the picture's own size.
    std::vector<std::vector<float>> planes;
    const std::vector<ExrChannel> channels =
        exr_channels(job.aovs, frames.plain, frames.for_aov("shaded").shaded, job.lines, planes);
    write_exr(job.plan.exr.string(), job.size.width, job.size.height, channels, metadata,
              make_matrices(job.camera, job.size));
    written.files.push_back(job.plan.exr);
}

Written write_files(const RenderJob& job, const Frames& frames, StageContext& context) {
    const ImageMetadata metadata =
        make_metadata(job.config, context.config, hash_file(job.config.model), job.tree.header(),
                      job.camera);
    make_folder(job.plan);
    Written written;
    for (std::size_t k = 0; k < job.plan.drawn.size(); ++k) {
        context.reporter.progress("pictures", k, job.plan.drawn.size());
        write_aov(job, k, frames, metadata, context, written);
    }
    if (!job.plan.exr.empty()) write_data(job, frames, metadata, written);
    if (!job.lines.empty())
        for (const auto& file : write_lines(job.config, job.plan.lines_svg(), job.size,
                                            job.tree.header().origin, frames.plain.lines, job.lines))
            written.files.push_back(file);
    return written;
}

Json make_result(const RenderJob& job, const Frames& frames, const Written& written) {
    Json files = Json::array();
    for (const auto& file : written.files) files.push_back(file.string());
    const RenderStats& s = frames.stats;
    const int factor = frames.has_fine ? job.config.supersample : 1;
    Json result = {{"files", files},
            {"width", job.size.width},
            {"height", job.size.height},
            {"rendered_pixels",
             static_cast<std::int64_t>(job.size.width) * job.size.height * factor * factor},
            {"covered_pixels", s.covered_pixels},
            {"surfels_drawn", s.surfels_drawn},
            {"loose_hidden", s.loose_hidden},
            {"nodes_visited", s.nodes_visited},
            {"root_tests", s.root_tests},
            {"distance_tests", s.distance_tests},
            {"unblended_pixels", s.unblended_pixels},
            {"frame_ms_median", frames.median_ms},
            {"ranges", written.ranges}};
    if (job.traced) {
        result["light_rays"] = (frames.has_fine ? frames.fine : frames.plain).light_counts.rays;
        result["scene_ms"] = job.traced->build_ms();
    }
    if (!job.lines.empty()) result["lines"] = lines_json(frames.plain.lines, job.lines);
    return result;
}

void require_surfels(const RenderConfig& config, const SurfelTree& tree) {
    if (tree.header().n_leaves == 0)
        throw DataError(config.model + ": a model without surfels cannot be drawn");
}

/// Curvature comes from the surfels' second derivatives, which planes do not have.
void warn_of_flat_surfels(const RenderJob& job, Reporter& reporter) {
    if (job.tree.header().degree > 1) return;
    for (const char* aov : {"mean", "gauss", "k1", "k2"})
        if (job.wants(aov))
            return reporter.warn(
                fmt::format("{}: a model of degree 1 is flat within each surfel, so that its "
                            "curvature says little: build it with --degree 2",
                            job.config.model));
}

}  // namespace

Json run_render(const RenderConfig& config, StageContext& context) {
    const std::vector<std::string> aovs = wanted_aovs(config);
    const OutputPlan plan = plan_outputs(config, aovs);
    const PictureSize size = parse_size(config.size);
    check_ranges(config);
    check_lines(config, aovs);
    check_tracing(config, aovs);
    parse_background(config.background, false);

    require_model(config.model);

    Stamp stamp(context, manifest_path(plan.named.string()));
    stamp.input(config.model);
    for (const std::string& model : config.add) stamp.input(model);
    stamp.depends("drawn as " + plan.stem.filename().string());
    for (const std::string& file : {config.lines_ply, config.lines_obj}) stamp.depends("lines to " + file);
    if (const char* epoch = std::getenv("SOURCE_DATE_EPOCH")) stamp.depends(epoch);
    if (config.repeat == 1)
        if (auto result = stamp.up_to_date()) return *result;

    const ModelFile model = ModelFile::open(config.model);
    const SurfelTree tree = model.tree();
    require_surfels(config, tree);
    std::optional<TracedModels> traced;
    if (is_traced(config)) traced.emplace(config, tree);
    const ModelHeader& framed = traced ? traced->header() : tree.header();
    const double room = legend_room(config, plan.drawn, size);
    const RenderJob job{config, tree, aovs, plan, size,
                        make_camera(config, framed, size, room),
                        wanted_lines(config, aovs, tree.header(), context.reporter),
                        traced ? &*traced : nullptr};
    warn_of_flat_surfels(job, context.reporter);
    const Frames frames = draw_frames(job, context);
    const Written written = write_files(job, frames, context);
    return stamp.commit(written.files, make_result(job, frames, written));
}

}  // namespace slim
