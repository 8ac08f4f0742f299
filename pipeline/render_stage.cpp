#include "pipeline/render_stage.h"

#include "formats/image_io.h"
#include "formats/model_file.h"
#include "pipeline/input_kind.h"
#include "pipeline/manifest.h"
#include "pipeline/render_bands.h"
#include "pipeline/render_directions.h"
#include "pipeline/render_job.h"
#include "pipeline/render_maps.h"
#include "pipeline/render_write.h"
#include "raytrace/brute/brute_renderer.h"
#include "raytrace/project/forward_renderer.h"
#include "raytrace/project/lod_cut.h"
#include "raytrace/project/tile_bins.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>

namespace slim {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

double milliseconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
        .count();
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const std::size_t n = values.size();
    return n % 2 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

/// A frame drawn again keeps the memory of its picture.
void shade_frame(int factor, RenderedFrame& frame) {
    const GBuffer& b = frame.buffer;
    const NormalPlanes normals{b.normal[0], b.normal[1], b.normal[2]};
    const auto rows_into = [&](const RowRange& rows, Picture& out) {
        shade_rows(b.width, b.height, frame.view, normals, b.hit, rows, {}, out);
    };
    if (factor == 1) return rows_into({0, b.height}, frame.shaded);
    const PictureSize size{b.width / factor, b.height / factor};
    frame.shaded = paint_in_bands({b.width, b.height}, size, [&](const RowRange& rows) {
        Picture band;
        rows_into(rows, band);
        return band;
    });
}

/// A frame of that size in which pixels stand for `factor` of the picture's: projection and what derives from it.
RenderStats draw_buffer(const RenderJob& job, const PictureSize& size, const PixelWindow& window, double lod,
                        Channels wanted, RenderedFrame& frame) {
    frame.size = size, frame.window = window;
    frame.pixels = pixel_view(job.camera, size.width, size.height);
    frame.view = shade_view(job.camera, size, window.x, window.y);
    const RenderRequest request{job.camera, size.width, size.height, wanted, lod, window, job.config.loose};
    const RenderStats stats = job.config.mode == "brute"
                                  ? render_brute(job.tree, request, frame.buffer)
                                  : render_forward(job.tree, request, frame.buffer);
    if (frame.buffer.has(kDirectionChannel | kK1Channel | kK2Channel))
        drop_undefined_directions(job.tree.header().diagonal, frame.buffer);
    return stats;
}

/// Projection, shading and lines: what a frame time means.
RenderStats draw_frame(const RenderJob& job, int factor, Channels wanted, bool with_shading,
                       const PicturePart& part, RenderedFrame& frame) {
    // LOD pixels are the picture's own: supersampling smooths edges, it does not refine the model.
    const RenderStats stats =
        draw_buffer(job, {job.size.width * factor, job.size.height * factor}, times(part.drawn, factor),
                    job.config.lod * factor, wanted, frame);
    if (with_shading) shade_frame(factor, frame);
    // Lines are found at the picture's own size: their strokes are smooth as they are.
    if (factor == 1) frame.lines = find_lines(job.camera, job.tree.header(), frame, job.lines);
    return stats;
}

/// Renders the frame of a factor as often as the job says; returns the median time.
double draw_repeatedly(const RenderJob& job, int factor, Channels wanted, const PicturePart& part,
                       StageContext& context, RenderedFrame& frame, RenderStats& stats) {
    std::vector<double> times;
    const auto repeats = static_cast<std::uint64_t>(job.config.repeat);
    for (std::uint64_t k = 0; k < repeats; ++k) {
        context.reporter.progress("frames", k, repeats);
        const auto start = std::chrono::steady_clock::now();
        stats = draw_frame(job, factor, wanted, job.wants("shaded"), part, frame);
        times.push_back(milliseconds_since(start));
    }
    return median(times);
}

std::uint64_t count_hits(const GBuffer& b, const PixelWindow& w) {
    std::uint64_t n = 0;
    for (int y = w.y; y < w.y + w.height; ++y)
        n += static_cast<std::uint64_t>(std::count(&b.hit[b.index(w.x, y)], &b.hit[b.index(w.x, y)] + w.width, 1));
    return n;
}

Frames draw_frames(const RenderJob& job, const PicturePart& part, StageContext& context) {
    const auto plain = plain_aovs(job), fine = fine_aovs(job);
    const bool lit = job.config.light_maps;
    const Channels plain_channels = channels_of(plain, lit) | job.for_lines();
    Frames frames;
    frames.has_fine = !fine.empty();
    if (frames.has_fine) {
        frames.median_ms = draw_repeatedly(job, job.config.supersample, channels_of(fine, lit), part,
                                           context, frames.fine, frames.stats);
        if (!plain.empty() || !job.lines.empty())
            draw_frame(job, 1, plain_channels, false, part, frames.plain);
    } else {
        frames.median_ms =
            draw_repeatedly(job, 1, plain_channels, part, context, frames.plain, frames.stats);
    }
    frames.covered = frames.has_fine
                         ? count_hits(frames.fine.buffer, times(part.inside(), job.config.supersample))
                         : count_hits(frames.plain.buffer, part.inside());
    if (job.wants("truth_distance"))
        frames.plain.truth_distance =
            truth_distances(job.config, job.tree.header().origin, frames.plain.buffer);
    return frames;
}

/// The longer side of the frame that ranges are taken from.
constexpr int kReferenceSide = 1000;

PictureSize reference_size(const PictureSize& size) {
    const int longer = std::max(size.width, size.height);
    if (longer <= kReferenceSide) return size;
    const auto scaled = [&](int side) {
        return std::max(1, static_cast<int>(std::int64_t{side} * kReferenceSide / longer));
    };
    return {scaled(size.width), scaled(size.height)};
}

/// Nodes that a view of that size visits.
void visit_view(const RenderJob& job, const PictureSize& size, const PixelWindow& window, double lod,
                std::vector<std::uint32_t>& visited) {
    CutCounts counts;
    counts.visited = &visited;
    lod_cut(job.tree, pixel_view(job.camera, size.width, size.height), whole_tiles(window),
            {lod, job.config.loose}, counts);
}

/// Checks what will be drawn of the model; returns the bytes of it that are read. A view of a part reads the pages
/// that it shows; where that is half of the file or more, all of it is checked as elsewhere.
std::uint64_t check_what_is_drawn(const ModelFile& model, const RenderJob& job) {
    if (job.config.mode == "forward" && job.tree.sharp().empty() && job.n_frames == 1 && !job.wants("color")) {
        std::vector<std::uint32_t> visited;
        visit_view(job, job.size, drawn_window(job.window, job.size), job.config.lod, visited);
        const PictureSize reference = reference_size(job.size);
        if (std::any_of(job.aovs.begin(), job.aovs.end(),
                        [&](const std::string& aov) { return needs_reference(job.config, aov); }))
            visit_view(job, reference, {0, 0, reference.width, reference.height},
                       job.config.lod * reference.width / job.size.width, visited);
        const std::uint64_t bytes = model.bytes_of_pages(visited);
        if (2 * bytes < model.file_size()) return model.check(visited), bytes;
    }
    model.check();
    return model.file_size();
}

/// Decides what holds for the picture as a whole: ranges, legends and their places, contour lines.
void choose_looks(RenderJob& job) {
    RenderedFrame reference;
    std::vector<std::string> aovs;
    for (const std::string& aov : job.plan.drawn)
        if (needs_reference(job.config, aov)) aovs.push_back(aov);
    if (job.wants("hillshade") && aovs.empty() && job.config.contours == "auto") aovs.push_back("hillshade");
    if (!aovs.empty()) {
        const PictureSize size = reference_size(job.size);
        const double scale = static_cast<double>(size.width) / job.size.width;
        draw_buffer(job, size, {0, 0, size.width, size.height}, job.config.lod * scale,
                    channels_of(aovs, false), reference);
        if (job.wants("truth_distance"))
            reference.truth_distance = truth_distances(job.config, job.tree.header().origin, reference.buffer);
        if (job.wants("hillshade")) choose_contours(job.config, reference.buffer, job.shadings.relief);
    }
    for (const std::string& aov : job.plan.drawn)
        job.looks[aov] = look_of(job.config, aov, reference, job.tree.header().diagonal, job.shadings.relief);
}

/// What a run came to.
struct Outcome {
    RenderStats stats;
    double frame_ms = 0;  ///< of all bands
    int factor = 1;
    int frames = 0;
    Json lines;
    std::vector<fs::path> files;
};

/// Parts of a picture may be empty.
void require_hits(const RenderJob& job, const RenderStats& stats) {
    if (stats.covered_pixels > 0 || !job.config.crop.empty() || !job.config.tile.empty()) return;
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

void add(const RenderStats& part, RenderStats& sum) {
    sum.nodes_visited += part.nodes_visited;
    sum.surfels_drawn += part.surfels_drawn;
    sum.loose_hidden += part.loose_hidden;
    sum.root_tests += part.root_tests;
    sum.distance_tests += part.distance_tests;
    sum.unblended_pixels += part.unblended_pixels;
}

/// Bytes that a pixel of the picture takes while it is drawn: planes, the picture, its crop and its bytes.
std::uint64_t pixel_bytes(const RenderJob& job) {
    const auto planes = [&](const std::vector<std::string>& aovs) {
        GBuffer one;
        one.resize(1, 1, channels_of(aovs, job.config.light_maps));
        std::uint64_t bytes = 1;
        one.for_each_plane([&](const auto& plane) { bytes += plane.size() * 4; });
        return bytes;
    };
    const auto factor = static_cast<std::uint64_t>(job.config.supersample);
    return 36 + planes(plain_aovs(job)) * (job.plan.exr.empty() ? 1 : 3) + factor * factor * planes(fine_aovs(job));
}

/// One picture of each AOV, of a film or the only one.
void draw_and_write(const RenderJob& job, const std::string& model_identity, StageContext& context,
                    Outcome& outcome) {
    const ImageMetadata metadata =
        make_metadata(job.config, context.config, model_identity, job.tree.header(), job.camera);
    const auto parts = picture_parts(job.size, job.window, pixel_bytes(job), !job.lines.empty());
    PictureFiles files(job.plan, job.size, job.window, parts.size() == 1, make_matrices(job.camera, job.size));
    for (std::size_t band = 0; band < parts.size(); ++band) {
        if (parts.size() > 1) context.reporter.progress("bands", band, parts.size());
        const Frames frames = draw_frames(job, parts[band], context);
        add(frames.stats, outcome.stats);
        outcome.stats.covered_pixels += frames.covered;
        outcome.frame_ms += frames.median_ms;
        outcome.factor = frames.has_fine ? job.config.supersample : 1;
        if (parts.size() == 1 && job.n_frames == 1) require_hits(job, outcome.stats);
        if (!write_band(job, frames, parts[band], metadata, files) && outcome.frames == 0 && band == 0)
            context.reporter.warn(job.plan.named.string() +
                                  ": too small for its legend or scale bar; legends are beside it as SVG");
        if (job.lines.empty()) continue;
        for (const auto& file : write_lines(job.config, job.plan.lines_svg(), job.size,
                                            job.tree.header().origin, frames.plain.lines, job.lines))
            outcome.files.push_back(file);
        outcome.lines = lines_json(frames.plain.lines, job.lines);
    }
    if (job.n_frames == 1) require_hits(job, outcome.stats);
    const auto pictures = files.commit();
    outcome.files.insert(outcome.files.end(), pictures.begin(), pictures.end());
    ++outcome.frames;
}

/// All pictures of the run; legends are those of the whole film.
Outcome draw_film(RenderJob& job, double free_right, const std::string& model_identity, StageContext& context) {
    const OutputPlan plan = job.plan;
    const int wanted = job.config.frame;
    Outcome outcome;
    for (int k = wanted > 0 ? wanted : 1; k <= (wanted > 0 ? wanted : job.n_frames); ++k) {
        if (job.n_frames > 1) {
            context.reporter.progress("pictures", static_cast<std::uint64_t>(k - 1),
                                      static_cast<std::uint64_t>(job.n_frames));
            job.camera = frame_camera(job.config, job.tree.header(), job.size, free_right, k - 1);
            job.plan = plan.numbered(k);
        }
        draw_and_write(job, model_identity, context, outcome);
    }
    job.plan = plan;
    require_hits(job, outcome.stats);
    for (const fs::path& file : write_legends(job)) outcome.files.push_back(file);
    return outcome;
}

Json ranges_json(const RenderJob& job) {
    Json ranges = Json::object();
    for (const std::string& aov : job.plan.drawn)
        if (const auto& legend = job.looks.at(aov).legend)
            ranges[aov] = Json::array({legend->range.lo, legend->range.hi});
    return ranges;
}

Json make_result(const RenderJob& job, const Outcome& outcome) {
    Json files = Json::array();
    for (const auto& file : outcome.files) files.push_back(file.string());
    const RenderStats& s = outcome.stats;
    Json result = {{"files", files},
            {"width", job.window.width},
            {"height", job.window.height},
            {"rendered_pixels",
             static_cast<std::int64_t>(job.window.width) * job.window.height * outcome.factor * outcome.factor},
            {"covered_pixels", s.covered_pixels},
            {"surfels_drawn", s.surfels_drawn},
            {"loose_hidden", s.loose_hidden},
            {"nodes", job.tree.n_nodes()},
            {"nodes_visited", s.nodes_visited},
            {"root_tests", s.root_tests},
            {"distance_tests", s.distance_tests},
            {"unblended_pixels", s.unblended_pixels},
            {"frame_ms_median", outcome.frame_ms / outcome.frames},
            {"ranges", ranges_json(job)}};
    if (!outcome.lines.is_null()) result["lines"] = outcome.lines;
    if (job.n_frames > 1) {
        result["frames"] = outcome.frames;
        result["film_commands"] = film_commands(job.plan);
    }
    if (job.camera.orthographic) result["pixel_size"] = job.camera.width / job.size.width;
    return result;
}

void require_surfels(const RenderConfig& config, const SurfelTree& tree) {
    if (tree.header().n_leaves == 0)
        throw DataError(config.model + ": a model without surfels cannot be drawn");
}

void require_scale(const RenderJob& job) {
    if (job.config.scale_bar && !job.camera.orthographic)
        throw ConfigError("scale_bar: a perspective picture has no one scale: draw it with --ortho");
}

/// Curvature comes from the surfels' second derivatives, which planes do not have.
void warn_of_flat_surfels(const RenderJob& job, Reporter& reporter) {
    if (job.tree.header().degree > 1) return;
    for (const char* aov : {"mean", "gauss", "k1", "k2", "dir1", "dir2"})
        if (job.wants(aov))
            return reporter.warn(
                fmt::format("{}: a model of degree 1 is flat within each surfel, so that its "
                            "curvature says little: build it with --degree 2",
                            job.config.model));
}

}  // namespace

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
        if (is_filterable(aov) && (drawn || is_color(aov))) aovs.push_back(aov);
    }
    return aovs;
}

Json run_render(const RenderConfig& config, StageContext& context) {
    std::vector<std::string> aovs = wanted_aovs(config);
    const PictureSize size = parse_size(config.size);
    check_ranges(config);
    check_lines(config, aovs);
    check_shadings(config, aovs);
    parse_background(config.background, false);
    const int frames = n_frames(config);
    if (frames > 1 && !(config.lines_ply + config.lines_obj).empty())
        throw ConfigError("lines_ply and lines_obj are for one picture, not for a turntable or path");
    const fs::path named = plan_outputs(config, aovs).named;

    require_model(config.model);

    const ModelFile model = ModelFile::open_by_pages(config.model);
    Stamp stamp(context, manifest_path(named.string()));
    stamp.input(config.model, model.identity());
    for (const std::string& file : {config.environment, config.matcap})
        if (!file.empty()) stamp.input(file);
    stamp.depends("drawn as " + named.stem().string());
    for (const std::string& file : {config.lines_ply, config.lines_obj}) stamp.depends("lines to " + file);
    if (const char* epoch = std::getenv("SOURCE_DATE_EPOCH")) stamp.depends(epoch);
    if (config.repeat == 1)
        if (auto result = stamp.up_to_date()) return *result;

    const SurfelTree tree = model.tree();
    require_surfels(config, tree);
    keep_possible_aovs(config, tree.header().degree, !model.colors().empty(), aovs);
    const OutputPlan plan = plan_outputs(config, aovs);
    const double room = legend_room(config, plan.drawn, size);
    const auto lines = wanted_lines(config, aovs, tree.header(), context.reporter);
    RenderJob job{config, tree, aovs, plan, size, frame_camera(config, tree.header(), size, room, 0), lines,
                  wanted_window(config, size, !lines.empty()), load_shadings(config, aovs, tree.header()), frames};
    if (job.wants("color")) job.shadings.colors.emplace(tree, model.colors());
    require_scale(job);
    warn_of_flat_surfels(job, context.reporter);
    const std::uint64_t bytes_read = check_what_is_drawn(model, job);
    make_folder(job.plan);
    choose_looks(job);
    const Outcome outcome = draw_film(job, room, model.identity(), context);
    if (frames > 1)
        for (const std::string& command : film_commands(job.plan)) context.reporter.info("as a film: " + command);
    Json result = make_result(job, outcome);
    result["model_bytes"] = model.file_size();
    result["model_bytes_read"] = bytes_read;
    return stamp.commit(outcome.files, std::move(result));
}

}  // namespace slim
